#pragma once
#include "constraints/equation_context.h"

namespace mimbre::constraints {

/// The axes of both frames stay parallel: b does not turn against a, and moves as it likes.
struct Orientation {
  static constexpr ConstraintInfo info{
      .name = "orientation", .equations = 3, .moment = true, .aligned = true};

  /// Of each axis of a with the next one of b, as of a fixed joint.
  template <class T>
  static void equations(const EquationContext<T>& c, ScalarEquation<T>* out) {
    for (int axis = 0; axis < 3; ++axis) out[axis] = axes_product<T>(c.motion, axis, (axis + 1) % 3);
  }
};

}  // namespace mimbre::constraints
