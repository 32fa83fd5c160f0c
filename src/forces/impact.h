#pragma once
#include <cmath>

#include "math/choice.h"
#include "math/elementary.h"

/// The force of an impact at the depth d: f(d) (1 + c ḋ), f = k e/n (d/e)ⁿ (Hunt and Crossley, J. Appl. Mech.
/// 42, 1975), which never pulls. With c = a/v₀, v₀ the speed of the impact, a body alone leaves with exactly
/// the share of v₀ that a belongs to (math/restitution.h).
namespace mimbre::forces::impact {

template <class T>
struct Push {
  T force, elastic, along_depth, along_speed;  ///< N; the part f(d); tangents by depth and by its speed
};

/// k, n, e; `d`: depth, `speed`: at which it grows, `factor`: c.
template <class T>
Push<T> push(const T& k, const T& n, const T& e, const T& d, const T& speed, const T& factor) {
  using mimbre::pow;
  const T none(0);
  const auto touches = d > none;
  if (!any(touches)) return {none, none, none, none};
  const T inside = select(touches, d, e), slope = k * pow(T(inside / e), T(n - T(1))),
          elastic = slope * inside / n, damped = T(1) + factor * speed;
  const auto pushes = select(touches, damped, none) > none;
  return {select(pushes, T(elastic * damped), none), select(touches, elastic, none),
          select(pushes, T(slope * damped), none), select(pushes, T(elastic * factor), none)};
}

/// c of an impact of that speed. Slower than `slow` none counts: what rests is damped.
template <class T>
T factor(const T& a, const T& speed, const T& slow) {
  return a / select(speed > slow, speed, slow);
}

}  // namespace mimbre::forces::impact
