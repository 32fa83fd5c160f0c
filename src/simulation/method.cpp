#include "mimbre/method.h"

#include <algorithm>

#include "integrate/rule.h"
#include "mimbre/diagnostics.h"
#include "mimbre/method_names.h"

namespace mimbre {
namespace {

constexpr double default_rho = 0.4;
/// The default integrator repeats an inaccurate step in this many parts.
constexpr int default_substeps = 4;
/// Of a fixed cost: what nearly all steps of vehicles and robots need.
constexpr int default_fixed_iterations = 6;
/// The first one may only find where to start from.
constexpr int least_fixed_iterations = 2;

}  // namespace

Method resolve_method(const spec::Simulation& given, const RunOptions& options) {
  using Rule = spec::Simulation::Integrator;
  const IntegratorOptions defaults;
  Method m;
  m.formulation = options.formulation.value_or(given.formulation);
  m.inertia = options.inertia.value_or(given.inertia);
  m.formalism = options.formalism.value_or(given.formalism);
  m.integrator = options.integrator.value_or(given.integrator);
  if (options.xi <= 0) m.integrator = Rule::newmark;
  if (options.rho >= 0 && (m.integrator == Rule::newmark || m.integrator == Rule::conserve))
    m.integrator = Rule::generalized_alpha;
  m.step = options.step > 0 ? options.step : given.step;
  m.rho = options.rho >= 0 ? options.rho : given.rho >= 0 ? given.rho : default_rho;
  if (m.integrator == Rule::hht) m.rho = std::max(m.rho, least_hht_rho);
  m.xi = options.xi <= 0 ? options.xi : given.xi;
  m.tolerance = options.tolerance > 0 ? options.tolerance
                : given.tolerance > 0 ? given.tolerance
                                      : defaults.tolerance;
  m.penalty = given.penalty > 0 ? given.penalty : defaults.penalty;
  m.fixed_cost = options.fixed_cost.value_or(given.fixed_cost);
  if (m.fixed_cost && m.formalism != spec::Simulation::Formalism::index3)
    throw InputError(Mark{}, std::string("steps of a fixed cost are made by the formalism index3, not by ") +
                                 name_of(m.formalism));
  m.max_iterations = options.max_iterations > 0 ? options.max_iterations
                     : given.max_iterations > 0 ? given.max_iterations
                     : m.fixed_cost             ? default_fixed_iterations
                                                : defaults.max_iterations;
  if (m.fixed_cost && m.max_iterations < least_fixed_iterations)
    throw InputError(Mark{}, "steps of a fixed cost need two iterations at least");
  if (m.integrator == Rule::conserve) m.xi = 0;
  // Other formalisms and Newmark's rule are there to be seen as they are.
  const bool repeats = m.formalism == spec::Simulation::Formalism::index3 && m.integrator != Rule::newmark &&
                       m.integrator != Rule::conserve;
  m.substeps = m.fixed_cost           ? 1
               : options.substeps > 0 ? options.substeps
               : given.substeps > 0   ? given.substeps
               : repeats              ? default_substeps
                                      : 1;
  m.end = options.end >= 0 ? options.end : given.end;
  m.default_end = options.end < 0 && !given.end_given && given.end == spec::Simulation{}.end;
  m.output_interval = given.output_interval;
  m.profile = options.profile;
  m.energies = options.energies || m.substeps > 1 || m.integrator == Rule::conserve;
  m.validity = options.validity;
  m.warnings = options.warnings;
  return m;
}

}  // namespace mimbre
