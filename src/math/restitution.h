#pragma once
#include <algorithm>
#include <cmath>

#include "math/elementary.h"

namespace mimbre {

/// The damping of an impact: a force f(d) (1 + c ḋ) at the depth d with c = a/v₀, v₀ the speed of the impact,
/// throws a body back with the share r (0 < r ≤ 1) of v₀ whatever its mass and f are. v dv/(1 + c v) = −f
/// dd/m, integrated from v₀ to −r v₀ over the same depths, gives a (1 + r) = log((1 + a)/(1 − a r)). Returns
/// a.
inline double restitution_damping(double r) {
  if (r >= 1 - 1e-9) return 0;
  // The difference falls from 0 first, and rises to infinity at 1/r. Newton's rule, between bounds.
  double low = 0, high = 1 / r, a = std::min(1.5 * (1 - r) / r, 0.5 * high);
  for (int k = 0; k < 100; ++k) {
    const double f = mimbre::log1p(a) - mimbre::log1p(-a * r) - a * (1 + r);
    (f < 0 ? low : high) = a;
    const double slope = 1 / (1 + a) + r / (1 - a * r) - (1 + r), next = a - f / slope;
    const double taken = next > low && next < high ? next : 0.5 * (low + high);
    if (std::abs(taken - a) <= 1e-15 * a) break;
    a = taken;
  }
  return a;
}

}  // namespace mimbre
