#pragma once
#include "constraints/equation_context.h"

namespace mimbre::constraints {

/// The z axes of both frames are at right angles.
struct Perpendicular {
  static constexpr ConstraintInfo info{
      .name = "perpendicular", .equations = 1, .moment = true, .axes = 2, .second_axis = true};

  template <class T>
  static void equations(const EquationContext<T>& c, ScalarEquation<T>* out) {
    out[0] = axes_product<T>(c.motion, 2, 2);
  }
};

}  // namespace mimbre::constraints
