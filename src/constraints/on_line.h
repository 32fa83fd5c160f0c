#pragma once
#include "constraints/equation_context.h"

namespace mimbre::constraints {

/// The origin of b lies on the line through a's origin along a's z.
struct OnLine {
  static constexpr ConstraintInfo info{
      .name = "on_line", .equations = 2, .lengths = 0b11, .force = true, .axes = 1};

  template <class T>
  static void equations(const EquationContext<T>& c, ScalarEquation<T>* out) {
    out[0] = along_axis<T>(c.motion, 0);
    out[1] = along_axis<T>(c.motion, 1);
  }
};

}  // namespace mimbre::constraints
