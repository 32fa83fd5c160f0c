#include "mimbre/method.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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

using Rule = spec::Simulation::Integrator;

[[noreturn]] void refuse(const std::string& text) { throw InputError(Mark{}, text); }

/// Each option by itself. What is not given has the value that RunOptions starts with.
void check_ranges(const RunOptions& o) {
  const auto check = [](bool sound, const char* name, double value, const char* wanted) {
    if (!sound) refuse(fmt::format("{} is {}; it must be {}", name, value, wanted));
  };
  check(std::isfinite(o.step) && o.step >= 0, "step", o.step, "a time in s, or 0 for the model's");
  check(o.rho <= 1, "rho", o.rho, "from 0 to 1, or negative for the default");
  check(o.xi == RunOptions{}.xi || (std::isfinite(o.xi) && o.xi <= 0), "xi", o.xi, "0 or less");
  check(std::isfinite(o.tolerance) && o.tolerance >= 0, "tolerance", o.tolerance,
        "positive, or 0 for the default");
  check(std::isfinite(o.accuracy) && o.accuracy >= 0, "accuracy", o.accuracy,
        "positive, or 0 for the default");
  check(o.substeps >= 0 && o.substeps <= 100, "substeps", o.substeps, "from 1 to 100, or 0 for the default");
  check(o.max_iterations >= 0 && o.max_iterations <= 1000, "max_iterations", o.max_iterations,
        "from 1 to 1000, or 0 for the default");
  check(!std::isnan(o.end), "end", o.end, "a time in s, or negative for the model's");
}

/// rho and xi belong to integrators, which are named or follow from them.
void check_integrator(const spec::Simulation& given, const RunOptions& o) {
  const bool has_rho = o.rho >= 0, has_xi = o.xi <= 0;
  const Rule rule = o.integrator.value_or(given.integrator);
  if (has_rho && has_xi)
    refuse(
        fmt::format("rho ({}) and xi ({}) exclude each other: rho belongs to generalized_alpha and hht, "
                    "xi to newmark",
                    o.rho, o.xi));
  if (has_rho && (rule == Rule::conserve || is_explicit(rule) || (o.integrator && rule == Rule::newmark)))
    refuse(fmt::format("rho is {}, but the integrator is {}{}; rho belongs to generalized_alpha and hht",
                       o.rho, name_of(rule), o.integrator ? "" : " in the model"));
  if (has_xi && o.integrator && rule != Rule::newmark)
    refuse(fmt::format("xi is {}, but the integrator is {}; xi belongs to newmark", o.xi, name_of(rule)));
  if (has_rho && rule == Rule::hht && o.rho < least_hht_rho)
    refuse(fmt::format("rho is {}; hht takes {} to 1", o.rho, least_hht_rho));
}

/// Explicit integrators have their own way to take constraints into account.
void check_explicit(const Method& m, const RunOptions& o) {
  if (o.accuracy > 0 && m.integrator != Rule::dopri853)
    refuse(fmt::format("accuracy is {}, but the integrator is {}; accuracy belongs to dopri853", o.accuracy,
                       name_of(m.integrator)));
  if (is_explicit(m.integrator) && m.formalism != spec::Simulation::Formalism::index3)
    refuse(fmt::format("{} is explicit and has no formalism, but the formalism is {}; leave it out",
                       name_of(m.integrator), name_of(m.formalism)));
  if (m.accuracy > 0 && o.substeps > 1)
    refuse(
        fmt::format("substeps is {}, but with accuracy the parts of a step follow from it; leave one of "
                    "them out",
                    o.substeps));
}

}  // namespace

Method resolve_method(const spec::Simulation& given, const RunOptions& options) {
  check_ranges(options);
  check_integrator(given, options);
  const IntegratorOptions defaults;
  Method m;
  m.formulation = options.formulation.value_or(given.formulation);
  m.inertia = options.inertia.value_or(given.inertia);
  m.formalism = options.formalism.value_or(given.formalism);
  m.integrator = options.integrator.value_or(given.integrator);
  if (options.xi <= 0) m.integrator = Rule::newmark;
  if (options.rho >= 0 && m.integrator == Rule::newmark) m.integrator = Rule::generalized_alpha;
  m.step = options.step > 0 ? options.step : given.step;
  m.rho = options.rho >= 0 ? options.rho : given.rho >= 0 ? given.rho : default_rho;
  if (m.integrator == Rule::hht) m.rho = std::max(m.rho, least_hht_rho);
  m.xi = options.xi <= 0 ? options.xi : given.xi;
  m.tolerance = options.tolerance > 0 ? options.tolerance
                : given.tolerance > 0 ? given.tolerance
                                      : defaults.tolerance;
  if (m.integrator == Rule::dopri853) m.accuracy = options.accuracy > 0 ? options.accuracy : given.accuracy;
  check_explicit(m, options);
  m.penalty = given.penalty > 0 ? given.penalty : defaults.penalty;
  m.fixed_cost = options.fixed_cost.value_or(given.fixed_cost);
  if (m.fixed_cost && m.accuracy > 0)
    refuse("steps of a fixed cost have no accuracy to keep; leave fixed_cost or accuracy out");
  if (m.fixed_cost && m.formalism != spec::Simulation::Formalism::index3)
    refuse(fmt::format("steps of a fixed cost are made by the formalism index3, not by {}",
                       name_of(m.formalism)));
  m.max_iterations = options.max_iterations > 0 ? options.max_iterations
                     : given.max_iterations > 0 ? given.max_iterations
                     : m.fixed_cost             ? default_fixed_iterations
                                                : defaults.max_iterations;
  if (m.fixed_cost && m.max_iterations < least_fixed_iterations)
    refuse("steps of a fixed cost need two iterations at least");
  if (m.fixed_cost && options.substeps > 1)
    refuse(fmt::format("a fixed cost makes each step once, but substeps is {}; leave one of them out",
                       options.substeps));
  if (m.integrator == Rule::conserve) m.xi = 0;
  // Other formalisms and Newmark's rule are there to be seen as they are.
  const bool repeats = m.formalism == spec::Simulation::Formalism::index3 && m.integrator != Rule::newmark &&
                       m.integrator != Rule::conserve;
  m.substeps = m.fixed_cost           ? 1
               : m.accuracy > 0       ? 1
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
