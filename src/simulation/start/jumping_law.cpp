#include "simulation/start/jumping_law.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "forces/spring.h"
#include "simulation/describe/names.h"

namespace mimbre {
namespace {

/// Where on the line from the start (0) to the last iteration (1) a law is looked at: an iteration that goes
/// back and forth has been on either side.
constexpr double line_from = -2, line_to = 4;
constexpr int law_samples = 96, bisections = 44;
constexpr double step_aside = 1e-9;
/// Of the law's range on the line: less is round-off of a steep slope.
constexpr double share_of_range = 0.01;

struct Jump {
  double from = 0, to = 0;
};

/// The largest step of f between neighbours, bisected: of what is continuous nothing is left.
template <class F>
std::optional<Jump> find_jump(const F& f) {
  std::array<double, law_samples + 1> y;
  const auto place = [](int k) { return line_from + (line_to - line_from) * k / law_samples; };
  for (int k = 0; k <= law_samples; ++k) y[k] = f(place(k));
  if (!std::all_of(y.begin(), y.end(), [](double value) { return std::isfinite(value); })) return {};
  int steepest = 0;
  for (int k = 1; k < law_samples; ++k)
    if (std::abs(y[k + 1] - y[k]) > std::abs(y[steepest + 1] - y[steepest])) steepest = k;
  const auto [least, most] = std::minmax_element(y.begin(), y.end());
  double a = place(steepest), b = place(steepest + 1), at_a = y[steepest], at_b = y[steepest + 1];
  for (int k = 0; k < bisections; ++k) {
    const double middle = 0.5 * (a + b), at_middle = f(middle);
    const bool first = std::abs(at_middle - at_a) > std::abs(at_b - at_middle);
    (first ? b : a) = middle;
    (first ? at_b : at_a) = at_middle;
  }
  // On either side of the one place where sign() is 0.
  at_a = f(a - step_aside);
  at_b = f(b + step_aside);
  if (!(std::abs(at_b - at_a) > share_of_range * (*most - *least))) return {};
  return Jump{at_a, at_b};
}

double between(const std::vector<double>& start, const std::vector<double>& last, int at, double s) {
  const auto k = static_cast<std::size_t>(at);
  return start[k] + s * (last[k] - start[k]);
}

}  // namespace

std::string jumping_law(const Compiled& m, const SeenByLaws& start, const SeenByLaws& last) {
  std::array<double, Formula::most_variables> x;
  // What time and inputs decide is the same in all iterations of a step.
  const auto slot = [&](int k, double s) {
    return k < m.signals.first_moving ? last.signals[static_cast<std::size_t>(k)]
                                      : between(start.signals, last.signals, k, s);
  };
  const auto value = [&](const LawData& law, std::size_t own, double s) {
    for (const int k : law.slots) x[own++] = slot(k, s);
    return law.formula.value(x.data());
  };
  const auto description_of = [](const std::string& who, const Jump& jump) {
    return fmt::format("{} jumps with the motion, from {:.4g} to {:.4g}", who, jump.from, jump.to);
  };
  for (const SignalsData::Computed& made : m.signals.moving) {
    if (made.block >= 0) continue;
    const auto jump = find_jump([&](double s) { return value(made.law, 0, s); });
    if (!jump) continue;
    for (std::size_t k = 0; k < m.signals.slot_of_signal.size(); ++k)
      if (m.signals.slot_of_signal[k] == made.slot) {
        const spec::Signal& signal = m.spec().signals[k];
        // "brake.command" is the expression for the force of actuator 'brake'.
        return description_of(signal.named ? fmt::format("signal '{}'", signal.name)
                                           : fmt::format("the expression of '{}'",
                                                         signal.name.substr(0, signal.name.rfind('.'))),
                              *jump);
      }
  }
  for (const ElementData& e : m.elements) {
    if (!law_info(e.law).of_functions) continue;
    const auto a = element_state_at(e, start.elements.data() + e.storage),
               b = element_state_at(e, last.elements.data() + e.storage);
    const auto jump = find_jump([&](double s) {
      x[0] = a.x[0] + s * (b.x[0] - a.x[0]);
      x[1] = a.v[0] + s * (b.v[0] - a.v[0]);
      return m.functions[e.functions + forces::spring::elastic].value(x[0]) +
             m.functions[e.functions + forces::spring::damping].value(x[1]) +
             (e.formula < 0 ? 0 : value(m.formulas[e.formula], 2, s));
    });
    if (jump) return description_of(element_name(m, e), *jump);
  }
  return {};
}

}  // namespace mimbre
