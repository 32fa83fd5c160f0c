#pragma once
#include "constraints/equation_context.h"

namespace mimbre::constraints {

/// Σ factor · coordinate = constant.
struct Coupling {
  static constexpr std::array<LawNumber, 1> numbers{
      {{.key = "constant", .unit = "m or rad", .about = "that the sum is equal to", .otherwise = 0}}};
  static constexpr ConstraintInfo info{.name = "coupling", .of_coordinates = true, .numbers = numbers};

  template <class T>
  static void equations(const EquationContext<T>& c, ScalarEquation<T>* out) {
    const ConstraintTerm& term = c.term;
    const ScalarEquation<T> e =
        coordinate<T>(term.joint, joint_info(term.joint).velocities, term.local, c.motion, c.known,
                      term.turns < 0 ? T(0) : c.states[term.turns]);
    if (term.turns >= 0) c.next[term.turns] = e.value;
    out[0] = T(term.factor) * e;
  }
};

}  // namespace mimbre::constraints
