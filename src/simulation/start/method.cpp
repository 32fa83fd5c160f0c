#include "mimbre/method.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "integrate/rule.h"
#include "mimbre/diagnostics.h"
#include "mimbre/method_names.h"
#include "mimbre/run_option.h"

namespace mimbre {
namespace {

/// The default integrator repeats an inaccurate step in this many parts.
constexpr int default_substeps = 4;
/// Of an integrator that is chosen.
constexpr double default_accuracy = 1e-6;
/// Of a fixed cost: what nearly all steps of vehicles and robots need.
constexpr int default_fixed_iterations = 6;

using Rule = spec::Simulation::Integrator;

[[noreturn]] void refuse(const std::string& text) { throw InputError(Mark{}, text); }

/// What is asked for, else what the model has, else the table's default.
void take(const RunOption& option, const spec::Simulation& given, const RunOptions& asked, Method& method) {
  std::visit(
      [&](const auto& m) {
        using Type = typename std::decay_t<decltype(m)>::type;
        if (m.asked && asked.*m.asked)
          method.*m.in_model = *(asked.*m.asked);
        else if (!is_given(option, given) && !std::isnan(option.otherwise))
          method.*m.in_model = static_cast<Type>(option.otherwise);
      },
      option.member);
}

}  // namespace

Method resolve_method(const spec::Simulation& given, const RunOptions& options) {
  for (const RunOption& option : run_option_table())
    if (const auto value = value_in(option, options))
      if (const std::string wrong = wrong_value(option, *value); !wrong.empty())
        refuse(fmt::format("{} {}", option.key, wrong));
  if (const auto conflict = find_conflict(given, options, OptionNames::keys)) refuse(conflict->message);
  const IntegratorOptions defaults;
  Method m;
  static_cast<spec::Simulation&>(m) = given;
  for (const RunOption& option : run_option_table()) take(option, given, options, m);
  m.integrator = integrator_in_force(given, options);
  if (m.integrator == Rule::hht) m.rho = std::max(m.rho, least_hht_rho);
  if (m.integrator == Rule::conserve) m.xi = 0;
  if (!estimates_error(m.integrator)) m.accuracy = 0;
  if (m.integrator == Rule::automatic && m.accuracy == 0) m.accuracy = default_accuracy;
  if (m.tolerance == 0) m.tolerance = defaults.tolerance;
  if (m.penalty == 0) m.penalty = defaults.penalty;
  if (m.max_iterations == 0)
    m.max_iterations = m.fixed_cost ? default_fixed_iterations : defaults.max_iterations;
  // Other formalisms and Newmark's rule are there to be seen as they are.
  using Formalism = spec::Simulation::Formalism;
  const bool repeats = (m.formalism == Formalism::index3 || m.formalism == Formalism::transfer_matrices ||
                        m.formalism == Formalism::global_modes) &&
                       m.integrator != Rule::newmark && m.integrator != Rule::conserve;
  if (m.fixed_cost || m.accuracy > 0)
    m.substeps = 1;
  else if (m.substeps == 0)
    m.substeps = repeats ? default_substeps : 1;
  m.default_end = !options.end && !given.end_given && given.end == spec::Simulation{}.end;
  m.profile = options.profile;
  m.energies = options.energies || m.substeps > 1 || m.integrator == Rule::conserve;
  m.validity = options.validity;
  m.warnings = options.warnings;
  return m;
}

}  // namespace mimbre
