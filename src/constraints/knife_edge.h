#pragma once
#include "constraints/equation_context.h"

namespace mimbre::constraints {

/// b's origin moves against a in no direction along b's z: a skate, a blade, a wheel seen from above.
struct KnifeEdge {
  static constexpr ConstraintInfo info{
      .name = "knife_edge", .equations = 1, .lengths = 0b1, .rates = 0b1, .force = true, .axes = 1};

  template <class T>
  static void equations(const EquationContext<T>& c, ScalarEquation<T>* out) {
    const RelativeMotion<T>& r = c.motion;
    const Vec3<T> across = r.rotation.col(2);
    out[0].linear = across;
    out[0].angular.setZero();
    out[0].bias = r.omega.cross(across).dot(r.velocity);
    out[0].value = T(c.rate_time) * out[0].rate(r);
  }
};

}  // namespace mimbre::constraints
