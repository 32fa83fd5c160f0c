#pragma once
#include <algorithm>

#include "compile/compiled.h"
#include "forces/element.h"

namespace mimbre {

/// Takes over into `states` (State::z) which turn joints, bushings and screws are in and where on their
/// curves bodies are, as of the last residual: what positions in a row wind up, with or without a motion
/// between them. Not what laws remember. `elements`, `constraints`: a workspace's storage.
inline void keep_turns(const Compiled& m, const double* elements, const double* constraints, double* states) {
  for (const ElementData& e : m.elements) {
    if (e.turns < 0) continue;
    const int count = e.measure == Measure::relative ? turning_states : 1;
    std::copy_n(element_state(e, elements).states + e.turns, count, states + e.states + e.turns);
  }
  for (const ConstraintData& c : m.constraints)
    std::copy_n(constraints + c.next_states, c.state_count, states + c.states);
}

/// Of screws and of couplings of cut joints.
inline bool counts_turns(const ConstraintData& c) { return c.state_count > 0 && c.curve.pieces.empty(); }

/// The same of what the last kinematics found of constraints that count turns.
inline void keep_counted_turns(const Compiled& m, const double* constraints, double* states) {
  for (const ConstraintData& c : m.constraints)
    if (counts_turns(c)) std::copy_n(constraints + c.next_states, c.state_count, states + c.states);
}

}  // namespace mimbre
