#include <cmath>

#include "mimbre/run_option.h"
#include "spec/check/checked_item.h"

/// Gravity, and how the model is computed.
namespace mimbre::checks {
namespace {

/// The model's section as what a caller could ask for.
RunOptions asked_in(const spec::Simulation& simulation) {
  RunOptions asked;
  for (const RunOption& option : run_option_table())
    std::visit(
        [&](const auto& m) {
          if (m.asked && is_given(option, simulation)) asked.*m.asked = simulation.*m.in_model;
        },
        option.member);
  asked.integrator = simulation.integrator;
  return asked;
}

void check_times(const CheckedItem& item, const spec::Simulation& s) {
  // Years of computing; a larger number is a mistake.
  constexpr double most_steps = 1e13;
  if (s.step > s.end) item.error(fmt::format("step {} is longer than end {}", s.step, s.end));
  if (!(s.end / s.step <= most_steps))
    item.error(fmt::format("a run to {} s has too many steps of {} s", s.end, s.step));
  if (s.output_interval == 0) return;
  const double steps = s.output_interval / s.step;
  if (!(steps >= 0.5) || std::abs(steps - std::round(steps)) > 1e-6 * steps)
    item.error(
        fmt::format("output_interval {} is not a whole number of steps of {}", s.output_interval, s.step));
}

}  // namespace

void check_simulation(const spec::Model& model, std::vector<Diagnostic>& errors) {
  const Mark mark{model.file, 0, 0};
  CheckedItem(errors, "model", mark).finite("gravity", model.gravity);
  const spec::Simulation& s = model.simulation;
  const CheckedItem item(errors, "simulation", mark);
  bool sound = true;
  for (const RunOption& option : run_option_table()) {
    const std::string wrong = is_given(option, s) ? wrong_value(option, value_in(option, s)) : std::string();
    if (wrong.empty()) continue;
    item.error(fmt::format("{} {}", option.key, wrong));
    sound = false;
  }
  if (!sound) return;
  check_times(item, s);
  if (const auto conflict = find_conflict({}, asked_in(s), OptionNames::keys)) item.error(conflict->message);
}

}  // namespace mimbre::checks
