#include "mimbre/method_arguments.h"

#include <fmt/format.h>

#include <algorithm>

#include "mimbre/method_names.h"
#include "mimbre/usage_error.h"

namespace mimbre {
namespace {

using Formulation = spec::Simulation::Formulation;
using Inertia = spec::Simulation::Inertia;
using Formalism = spec::Simulation::Formalism;
using Integrator = spec::Simulation::Integrator;

/// The enumerator of that name; nothing when the name is empty. The caller has checked the name.
template <class Enumeration, class Names>
std::optional<Enumeration> enumerator(const std::string& name, const Names& names) {
  if (name.empty()) return {};
  return static_cast<Enumeration>(std::find(names.begin(), names.end(), name) - names.begin());
}

/// The integrator that the command line asks for, by its name or by a parameter that only fits one.
std::optional<Integrator> integrator_asked_for(const MethodArguments& arguments,
                                               const spec::Simulation& given) {
  const auto named_one = enumerator<Integrator>(arguments.integrator, method_names::integrators);
  const bool of_newmark = named_one.value_or(given.integrator) == Integrator::newmark;
  const Integrator one = named_one.value_or(given.integrator);
  const bool has_none = one == Integrator::conserve || is_explicit(one);
  if (arguments.accuracy && one != Integrator::dopri853)
    throw UsageError(fmt::format("--accuracy belongs to dopri853, not to {}; give --integrator dopri853, too",
                                 name_of(one)));
  if ((arguments.rho || arguments.xi) && named_one && has_none)
    throw UsageError(fmt::format("{} belongs to other integrators; {} has none",
                                 arguments.rho ? "--rho" : "--integrator-xi", name_of(one)));
  if (arguments.rho && has_none)
    throw UsageError(
        fmt::format("--rho belongs to generalized_alpha and hht, and the model's integrator is {}; name the "
                    "one that you mean with --integrator, too",
                    name_of(one)));
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

RunOptions run_options(const MethodArguments& arguments, const spec::Simulation& given) {
  RunOptions options;
  options.formulation = enumerator<Formulation>(arguments.formulation, method_names::formulations);
  options.inertia = enumerator<Inertia>(arguments.inertia, method_names::inertias);
  options.formalism = enumerator<Formalism>(arguments.formalism, method_names::formalisms);
  options.integrator = integrator_asked_for(arguments, given);
  if (arguments.xi) options.xi = *arguments.xi;
  if (arguments.rho) options.rho = *arguments.rho;
  if (arguments.tolerance) options.tolerance = *arguments.tolerance;
  if (arguments.accuracy) options.accuracy = *arguments.accuracy;
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

}  // namespace mimbre
