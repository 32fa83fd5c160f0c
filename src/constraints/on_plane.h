#pragma once
#include "constraints/equation_context.h"

namespace mimbre::constraints {

/// The origin of b lies on the plane through a's origin at right angles to a's z.
struct OnPlane {
  static constexpr ConstraintInfo info{
      .name = "on_plane", .equations = 1, .lengths = 0b1, .force = true, .axes = 1};

  template <class T>
  static void equations(const EquationContext<T>& c, ScalarEquation<T>* out) {
    out[0] = along_axis<T>(c.motion, 2);
  }
};

}  // namespace mimbre::constraints
