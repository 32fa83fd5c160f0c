#include "portable/time_events.h"

#include <algorithm>
#include <cmath>

namespace mimbre::portable {
namespace {

/// Differences below this share of both values are round-off.
constexpr double round_off = 1e-9;

/// Value and two derivatives of a piece.
Jet at(const Pieces::Arrays& p, std::size_t piece, double x) {
  double v = 0, d = 0, half = 0;
  const double s = x - p.origins[piece];
  for (std::size_t i = p.first[piece + 1]; i-- > p.first[piece];) {
    half = half * s + d;
    d = d * s + v;
    v = v * s + p.coefficients[i];
  }
  return {v, d, 2 * half};
}

bool differ(double a, double b) { return std::abs(a - b) > round_off * (std::abs(a) + std::abs(b)); }
bool breaks(const Jet& before, const Jet& after, int derivatives) {
  return differ(before.value, after.value) || (derivatives > 0 && differ(before.first, after.first)) ||
         (derivatives > 1 && differ(before.second, after.second));
}

/// Adds the events of one function, where it or one of so many derivatives jumps.
void add_events(const FunctionData& function, int derivatives, std::vector<TimeEvent>& all) {
  if (function.integral() && derivatives > 0)
    return add_events(function.integral()->f.front(), derivatives - 1, all);
  if (!function.pieces()) return;
  const Pieces::Arrays p = function.pieces()->arrays();
  const double start = p.wrap.start, period = p.wrap.period;
  std::size_t first = 0, last = p.breaks.size();  // pieces at both ends of a period
  for (std::size_t k = 0; k < p.breaks.size(); ++k) {
    const double x = p.breaks[k];
    if (period > 0 && x <= start) first = k + 1;
    if (period > 0 && x >= start + period) last = std::min(last, k);
    if (period > 0 && !(x > start && x < start + period)) continue;
    if (breaks(at(p, k, x), at(p, k + 1, x), derivatives)) all.push_back({x, period});
  }
  if (period > 0 && breaks(at(p, last, start + period), at(p, first, start), derivatives))
    all.push_back({start, period});
}

/// Whether a law is the time alone.
bool is_time(const LawData& law) {
  const auto& code = law.formula.program().code;
  return code.size() == 1 && code[0].op == ExpressionProgram::Op::variable && law.slots[code[0].at] == 0;
}

}  // namespace

std::vector<TimeEvent> time_events(const Compiled& m) {
  std::vector<TimeEvent> all;
  for (const SignalsData::OfTime& f : m.signals.of_time)
    add_events(
        f.function,
        std::any_of(m.drives.begin(), m.drives.end(), [&](const DriveData& d) { return d.slot == f.slot; })
            ? 2
            : 1,
        all);
  // A block may drive a joint by way of other signals.
  for (const SignalsData::Block& b : m.signals.blocks)
    if (b.function >= 0 && b.laws.size() == 1 && is_time(b.laws[0]))
      add_events(m.signals.functions[static_cast<std::size_t>(b.function)], m.drives.empty() ? 1 : 2, all);
  std::sort(all.begin(), all.end(), [](const TimeEvent& a, const TimeEvent& b) { return a.time < b.time; });
  return all;
}

}  // namespace mimbre::portable
