#include "simulation/start/drive_smoothness.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "signals/values.h"

namespace mimbre {
namespace {

constexpr int drive_samples = 4000, suspects = 16, halvings = 12;

using Law = std::function<double(double)>;

double second_difference(const Law& law, double at, double h) {
  return std::abs(law(at - h) - 2 * law(at) + law(at + h));
}

/// Moves to the place within ±h of `at` with the largest second difference for half of h.
double nearer(const Law& law, double at, double h) {
  double best = at, most = -1;
  for (int k = -2; k <= 2; ++k) {
    const double x = at + 0.5 * k * h, now = second_difference(law, x, 0.5 * h);
    if (now > most) {
      most = now;
      best = x;
    }
  }
  return best;
}

}  // namespace

Break largest_break(const Function& law, double end) {
  if (law.is_zero()) return {};
  return largest_break([&](double t) { return law.value(t); }, end);
}

Break largest_break(const std::function<double(double)>& law, double end) {
  if (!(end > 0)) return {};
  const double h = end / drive_samples;
  std::vector<double> bend(drive_samples + 1, 0.0);
  double slope = 0;
  for (int k = 1; k < drive_samples; ++k) {
    bend[static_cast<std::size_t>(k)] = second_difference(law, k * h, h);
    slope = std::max(slope, std::abs(law(k * h + h) - law(k * h - h)) / (2 * h));
  }
  std::vector<int> order;
  for (int k = 1; k < drive_samples; ++k) {
    const auto i = static_cast<std::size_t>(k);
    if (bend[i] > 0 && bend[i] >= bend[i - 1] && bend[i] >= bend[i + 1]) order.push_back(k);
  }
  const auto count = std::min<std::ptrdiff_t>(suspects, std::ssize(order));
  std::partial_sort(order.begin(), order.begin() + count, order.end(), [&](int a, int b) {
    return bend[static_cast<std::size_t>(a)] > bend[static_cast<std::size_t>(b)];
  });
  Break worst;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    double at = order[static_cast<std::size_t>(i)] * h, width = h;
    double first = 0;  // a few halvings on, where the suspect is alone
    for (int k = 0; k < halvings; ++k, width /= 2) {
      at = nearer(law, at, width);
      if (k == 3) first = second_difference(law, at, width / 2);
    }
    // What halving leaves of the second difference after the eight: of a jump all, of a kink 2⁻⁸, of a smooth
    // law 2⁻¹⁶.
    const double last = second_difference(law, at, width), left = last / first, kink = last / width;
    if (!(first > 1e-9 * slope * h) || !std::isfinite(left)) continue;
    Break found;
    if (left > 0.25)
      found = {Break::Kind::jump, at, last};
    else if (left > 0x1p-10 && kink > 1e-3 * slope)
      found = {Break::Kind::kink, at, kink};
    const bool more = found.kind == worst.kind
                          ? found.size > worst.size
                          : found.kind == Break::Kind::jump || worst.kind == Break::Kind::none;
    if (found.kind != Break::Kind::none && more) worst = found;
  }
  return worst;
}

std::vector<std::string> drive_warnings(const Compiled& m, double end) {
  std::vector<std::string> all;
  for (const DriveData& d : m.drives) {
    // What inputs do is not known before.
    SignalValues<double> signals(m);
    const auto position = [&](double t) {
      fix_signals(m.signals, t, signals);
      return signals.value[d.slot];
    };
    const Break worst = largest_break(position, end);
    if (worst.kind == Break::Kind::none) continue;
    const bool jump = worst.kind == Break::Kind::jump;
    all.push_back(fmt::format(
        "the drive of joint '{}' {} by {:.3g} at t = {:.4g} s: that takes {}, which joint forces in the "
        "results do not show, or show as the step resolves it; {}",
        m.spec().joints[d.joint_spec].name, jump ? "jumps" : "changes its speed at once", worst.size,
        worst.at, jump ? "an infinite force" : "an impact, an unbounded force in an instant",
        "use `interpolation: cubic` or an expression with continuous speed"));
  }
  return all;
}

}  // namespace mimbre
