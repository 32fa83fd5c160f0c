#include "app/method_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "mimbre/method_names.h"

namespace mimbre::app {
namespace {

using Formulation = spec::Simulation::Formulation;
using Inertia = spec::Simulation::Inertia;
using Formalism = spec::Simulation::Formalism;
using Integrator = spec::Simulation::Integrator;

/// The enumerator of that name; nothing when the name is empty. The parser has checked the name.
template <class Enumeration, class Names>
std::optional<Enumeration> named(const std::string& name, const Names& names) {
  if (name.empty()) return {};
  return static_cast<Enumeration>(std::find(names.begin(), names.end(), name) - names.begin());
}

/// The integrator that the command line asks for, by its name or by a parameter that only fits one.
std::optional<Integrator> integrator_asked_for(const MethodArguments& arguments,
                                               const spec::Simulation& given) {
  const auto named_one = named<Integrator>(arguments.integrator, method_names::integrators);
  const bool of_newmark = named_one.value_or(given.integrator) == Integrator::newmark;
  const bool of_conserve = named_one.value_or(given.integrator) == Integrator::conserve;
  if ((arguments.rho || arguments.xi) && named_one && of_conserve)
    throw UsageError(fmt::format("{} belongs to other integrators; conserve has none",
                                 arguments.rho ? "--rho" : "--integrator-xi"));
  if (arguments.rho && of_conserve)
    throw UsageError(
        "--rho belongs to generalized_alpha and hht, and the model's integrator is conserve; name the one "
        "that you mean with --integrator, too");
  if (arguments.rho && named_one && of_newmark)
    throw UsageError("--rho belongs to generalized_alpha and hht; newmark has --integrator-xi");
  if (arguments.xi && named_one && !of_newmark)
    throw UsageError(fmt::format("--integrator-xi belongs to newmark; {} has --rho", arguments.integrator));
  if (arguments.xi) return Integrator::newmark;
  if (arguments.rho && of_newmark) return Integrator::generalized_alpha;
  return named_one;
}

/// What else is asked for must not go unheard.
void check_fixed_cost(const MethodArguments& arguments, const RunOptions& options,
                      const spec::Simulation& given) {
  if (!options.fixed_cost.value_or(given.fixed_cost)) return;
  const bool asked = arguments.fixed_cost;
  if (arguments.substeps > 1)
    throw UsageError(asked ? "--fixed-cost makes each step once; leave --substeps out"
                           : "the model has fixed_cost, which makes each step once; leave --substeps out, or "
                             "take --no-fixed-cost, too");
  if (options.formalism.value_or(given.formalism) != Formalism::index3)
    throw UsageError(asked ? "--fixed-cost is of the formalism index3"
                           : "the model has fixed_cost, which is of the formalism index3; take "
                             "--no-fixed-cost, too");
}

}  // namespace

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
      "conserve: generalized-alpha with its error of energy taken back");
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

RunOptions run_options(const MethodArguments& arguments, const spec::Simulation& given) {
  RunOptions options;
  options.formulation = named<Formulation>(arguments.formulation, method_names::formulations);
  options.inertia = named<Inertia>(arguments.inertia, method_names::inertias);
  options.formalism = named<Formalism>(arguments.formalism, method_names::formalisms);
  options.integrator = integrator_asked_for(arguments, given);
  if (arguments.xi) options.xi = *arguments.xi;
  if (arguments.rho) options.rho = *arguments.rho;
  if (arguments.tolerance) options.tolerance = *arguments.tolerance;
  options.max_iterations = arguments.max_iterations;
  options.substeps = arguments.substeps;
  if (arguments.fixed_cost || arguments.no_fixed_cost) options.fixed_cost = arguments.fixed_cost;
  check_fixed_cost(arguments, options, given);
  if (options.integrator.value_or(given.integrator) == Integrator::hht && arguments.rho &&
      options.rho < least_hht_rho)
    throw UsageError(fmt::format("--rho {}: hht takes {} to 1", options.rho, least_hht_rho));
  return options;
}

RunPlan planned(const spec::Simulation& given, const RunOptions& options, std::optional<double> step,
                std::optional<double> until) {
  RunOptions asked = options;
  if (until) asked.end = *until;
  const Method method = resolve_method(given, asked);
  const double end = method.end, length = method.step;
  if ((step || until) && longer_than_run(length, end))
    throw UsageError(
        fmt::format("the step of {} s is longer than the run, which ends at {} s; give a shorter "
                    "--step or a later --until",
                    length, end));
  return plan_run(end, method.output_interval, length);
}

Json to_json(const MethodArguments& arguments) {
  Json json = Json::object();
  const auto word = [&](const char* key, const std::string& value) {
    if (!value.empty()) json[key] = value;
  };
  word("formulation", arguments.formulation);
  word("inertia", arguments.inertia);
  word("formalism", arguments.formalism);
  word("integrator", arguments.integrator);
  if (arguments.xi) json["integrator_xi"] = *arguments.xi;
  if (arguments.rho) json["rho"] = *arguments.rho;
  if (arguments.tolerance) json["tolerance"] = *arguments.tolerance;
  if (arguments.max_iterations) json["max_iterations"] = arguments.max_iterations;
  if (arguments.substeps) json["substeps"] = arguments.substeps;
  if (arguments.fixed_cost || arguments.no_fixed_cost) json["fixed_cost"] = arguments.fixed_cost;
  return json;
}

Json method_json(const Method& method) {
  Json json;
  json["formulation"] = name_of(method.formulation);
  json["inertia"] = name_of(method.inertia);
  json["formalism"] = name_of(method.formalism);
  json["integrator"] = name_of(method.integrator);
  if (method.integrator == Integrator::newmark)
    json["xi"] = method.xi;
  else if (method.integrator != Integrator::conserve)
    json["rho"] = method.rho;
  json["tolerance"] = method.tolerance;
  return json;
}

Json resolved_json(const Method& method) {
  Json json = method_json(method);
  json["inertia"] = name_of(method.inertia);
  json["penalty"] = method.penalty;
  json["max_iterations"] = method.max_iterations;
  json["substeps"] = method.substeps;
  json["fixed_cost"] = method.fixed_cost;
  json["step"] = method.step;
  json["end"] = method.end;
  json["default_end"] = method.default_end;
  json["output_interval"] = method.output_interval;
  return json;
}

}  // namespace mimbre::app
