#pragma once
#include "constraints/scalar_equation.h"
#include "math/space_curve.h"

namespace mimbre::constraints {

/// b's origin d on a curve c(s) of a: what leads from its nearest point to it, e = d − c(s) with c' · e = 0,
/// has no component along two directions n(s) across the curve, Φ = n · e. From c' · e = 0
///
///     ṡ = c' · u / (c' · c' − e · c'')
///     Φ̇ = n · u + (n' · e) ṡ                    since n · c' = 0 at most up to the size of e
///
/// so that with g = n' · e − n · c'
///
///     Φ̈ = n · u̇ + g s̈ + (2 n' · u) ṡ + (n'' · e − 2 n' · c' − n · c'') ṡ²
///     s̈ = (c' · u̇ + 2 c'' · u ṡ + (e · c''' − 3 c' · c'') ṡ²) / (c' · c' − e · c'')
///
/// of which e · c''' ṡ² is left out: g and e vanish where Φ does. `last`: s at the start of the step, near
/// which the nearest point is looked for; it is returned.
template <class T>
T on_curve(const SpaceCurve& curve, const RelativeMotion<T>& r, const T& last, ScalarEquation<T>* out) {
  CurvePoint<T> at;
  const T s = nearest_near<T>(curve, r.displacement, last, at);
  const Vec3<T>&c1 = at.first[0], &c2 = at.second[0];
  const Vec3<T> e = r.displacement - at.value[0], &u = r.velocity;
  const T speed = c1.squaredNorm(), bend = speed - e.dot(c2);
  // At a centre of curvature all points are as near: any of them, far from where Φ vanishes.
  const T stretch = select(bend * bend > T(1e-6) * speed * speed, bend, speed);
  const T rate = c1.dot(u) / stretch;
  const T own = (T(2) * c2.dot(u) * rate - T(3) * c1.dot(c2) * rate * rate) / stretch;
  for (int k = 0; k < 2; ++k) {
    const Vec3<T>&n = at.value[1 + k], &n1 = at.first[1 + k], &n2 = at.second[1 + k];
    const T g = n1.dot(e) - n.dot(c1);
    out[k].value = n.dot(e);
    out[k].linear = n + (g / stretch) * c1;
    out[k].angular.setZero();
    out[k].bias =
        g * own + T(2) * n1.dot(u) * rate + (n2.dot(e) - T(2) * n1.dot(c1) - n.dot(c2)) * rate * rate;
  }
  return s;
}

}  // namespace mimbre::constraints
