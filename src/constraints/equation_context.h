#pragma once
#include "compile/compiled.h"
#include "constraints/parts.h"
#include "spec/constraint_kind.h"

namespace mimbre {

/// What the equations of a constraint may depend on.
template <class T>
struct EquationContext {
  const ConstraintData& data;
  const ConstraintTerm& term;  ///< one of its terms: of a sum of coordinates, of which that is a summand
  const RelativeMotion<T>& motion;
  const T* known;   ///< positions of the term's joint in the tree; null elsewhere
  const T* states;  ///< of the constraint, at the step's start,
  T* next;          ///< and at its end
  /// s: what an equation of velocities alone takes times its rate for its value (System::set_rate_time).
  double rate_time = 0;
  const RoadData* road = nullptr;  ///< of a constraint on one

  T number(int k) const { return T(data.numbers[k]); }
};

}  // namespace mimbre
