#pragma once
#include "constraints/equation_context.h"

namespace mimbre::constraints {

/// The z axes of both frames are parallel, of either sense.
struct Parallel {
  static constexpr ConstraintInfo info{.name = "parallel", .equations = 2, .moment = true, .axes = 2};

  template <class T>
  static void equations(const EquationContext<T>& c, ScalarEquation<T>* out) {
    out[0] = axes_product<T>(c.motion, 0, 2);
    out[1] = axes_product<T>(c.motion, 1, 2);
  }
};

}  // namespace mimbre::constraints
