#include "app/method_options.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "mimbre/method_names.h"
#include "mimbre/run_summary.h"

namespace mimbre::app {

void add_method_options(Parser& command, MethodArguments& arguments, MethodChoice choice) {
  const auto add = [&](const char* option, std::string& target, const auto& names, const char* help) {
    command.add_option(option, target, help)
        .one_of({names.begin(), names.end()})
        .type_name("NAME")
        .group("Method");
  };
  if (choice.formulation)
    add("--formulation", arguments.formulation, method_names::formulations,
        "Coordinates, instead of the model's:\n"
        "relative: of the joints, by recursion\n"
        "natural: points and unit vectors of the bodies");
  add("--inertia", arguments.inertia, method_names::inertias,
      "Inertia of flexible bodies:\n"
      "integrals: shape integrals, computed once\n"
      "projection: of the mesh's mass matrix in every evaluation\n"
      "projection_translations: the same with the nodes' translations only");
  if (!choice.motion) return;
  add("--formalism", arguments.formalism, method_names::formalisms,
      "How the constraints enter the equations of motion:\n"
      "index3: augmented Lagrangian, with projections\n"
      "index1: Lagrange multipliers\n"
      "baumgarte: the same, stabilised\n"
      "penalty: penalty alone\n"
      "index1_augmented: penalty with iterated multipliers\n"
      "independent: independent coordinates");
  add("--integrator", arguments.integrator, method_names::integrators,
      "How steps are made:\n"
      "generalized_alpha: second order, damps what the step cannot resolve\n"
      "newmark: the trapezoidal rule, or with xi below 0 damped\n"
      "hht: Hilber, Hughes, Taylor\n"
      "conserve: generalized-alpha with its error of energy taken back\n"
      "rk4: explicit, fourth order, for mechanisms without stiff parts\n"
      "dopri853: explicit, eighth order, likewise");
  command
      .add_option("--accuracy", arguments.accuracy,
                  "dopri853 divides steps by this error of each part, relative to the\n"
                  "mechanism's size; without it a step has one part")
      .from(1e-15, 1)
      .type_name("A")
      .group("Method");
  const Option xi = command.add_option("--integrator-xi", arguments.xi, "newmark with this xi, 0 or less")
                        .from(-INFINITY, 0)
                        .type_name("XI")
                        .group("Method");
  command
      .add_option("--rho", arguments.rho,
                  "Spectral radius of generalized_alpha, 0 to 1, or of hht, 0.5 to 1;\n"
                  "where the model has newmark: generalized_alpha with it")
      .from(0, 1)
      .type_name("R")
      .excludes(xi)
      .group("Method");
  command
      .add_option("--tolerance", arguments.tolerance,
                  "Tolerance of the iterations, relative to the accelerations at play,\ninstead of the "
                  "model's (1e-5 if it has none)")
      .from(1e-15, 1)
      .type_name("X")
      .group("Method");
  command
      .add_option(
          "--max-iterations", arguments.max_iterations,
          "Most iterations of a step, or of each part of one, instead of the\nmodel's (30 if it has none)")
      .within(1, 1000)
      .type_name("N")
      .group("Method");
  command
      .add_option("--substeps", arguments.substeps,
                  "Parts in which a step is repeated that an impact made inaccurate,\ninstead of the "
                  "model's; 1: never")
      .within(1, 100)
      .type_name("N")
      .group("Method");
  const Option fixed =
      command
          .add_flag("--fixed-cost", arguments.fixed_cost,
                    "For real time: each step is made once, and accepted after\n--max-iterations (6 if "
                    "neither the option nor the model sets them)")
          .group("Method");
  command
      .add_flag("--no-fixed-cost", arguments.no_fixed_cost,
                "Iterate each step until it converges, even if the model has fixed_cost")
      .excludes(fixed)
      .group("Method");
}

Json arguments_json(const MethodArguments& arguments) { return Json::parse(arguments_summary(arguments)); }

Json method_json(const Method& method) { return Json::parse(method_summary(method)); }

std::string method_words(const Method& method) {
  if (!is_explicit(method.integrator))
    return fmt::format("{}, {}, {}", name_of(method.formulation), name_of(method.formalism),
                       name_of(method.integrator));
  const std::string accuracy = method.accuracy > 0 ? fmt::format(", accuracy {:g}", method.accuracy) : "";
  return fmt::format("{}, {}{}", name_of(method.formulation), name_of(method.integrator), accuracy);
}

Json resolved_json(const Method& method) { return Json::parse(resolved_summary(method)); }

}  // namespace mimbre::app
