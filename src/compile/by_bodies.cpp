#include "compile/by_bodies.h"

#include <algorithm>
#include <vector>

namespace mimbre {
namespace {

constexpr int most_coordinates = 60;
/// Operations of the sparse matrix for one of the elimination by bodies, at which both take the same time.
constexpr double times_more = 20;

bool is_on_one_body(const ElementData& e, const Compiled& m) {
  if (e.pooled || e.measure == Measure::sum || e.leg) return false;
  if (e.body >= 0 || e.path.entries.empty()) return true;
  return e.inertia < 0 && acts_on_body(e, m);
}

}  // namespace

std::optional<OnBody> acts_on_body(const ElementData& e, const Compiled& m) {
  if (e.path.entries.size() == 1) {
    const PathEntry& entry = e.path.entries[0];
    return OnBody{entry.body, entry.plus, entry.minus, false};
  }
  const auto body_of = [&](int frame) { return frame < 0 ? -1 : m.frames[frame].body; };
  const int a = body_of(e.frame_a), b = body_of(e.frame_b);
  if (a >= 0 && b >= 0) return std::nullopt;
  for (const PathEntry& entry : e.path.entries)
    if (entry.body == std::max(a, b)) return OnBody{entry.body, entry.plus, entry.minus, true};
  return std::nullopt;
}

bool splits_by_bodies(const Compiled& m) {
  return m.loops.empty() && m.constraints.empty() &&
         std::all_of(m.bodies.begin(), m.bodies.end(),
                     [](const BodyData& b) { return b.size() <= most_coordinates; }) &&
         std::all_of(m.elements.begin(), m.elements.end(),
                     [&](const ElementData& e) { return is_on_one_body(e, m); });
}

bool is_eliminated_by_bodies(const Compiled& m) {
  if (!splits_by_bodies(m)) return false;
  double sparse = 0, by_bodies = 0;
  std::vector<double> above(m.bodies.size(), 0);  // coordinates between a body and the root
  for (std::size_t i = 0; i < m.bodies.size(); ++i) {
    const BodyData& b = m.bodies[i];
    const double n = b.size();
    if (b.parent >= 0) {
      const auto parent = static_cast<std::size_t>(b.parent);
      const double p = m.bodies[parent].size();
      above[i] = above[parent] + p;
      by_bodies += 36 * p + 6 * p * p;
    }
    sparse += n * n * n / 3 + n * n * above[i] + n * above[i] * above[i] + 6 * n * above[i];
    by_bodies += n * n * n / 3 + 6 * n * n + 36 * n;
  }
  return sparse > times_more * by_bodies;
}

}  // namespace mimbre
