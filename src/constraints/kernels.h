#pragma once
#include "compile/compiled.h"
#include "constraints/closures.h"
#include "constraints/curve.h"
#include "joints/table.h"

/// The equations of a constraint by its kind. Apart from the table (spec/constraint_kinds.h), so that
/// a unit that only asks for their number does not compile them.
namespace mimbre::constraints {

/// Of one of its terms: c.count equations, of a coupling the term's share. `known`: positions of a coupling's
/// joint in the tree, null elsewhere. `states`, `next`: of the constraint, at the step's start and at its
/// end.
template <class T>
void equations(const ConstraintData& c, const ConstraintTerm& term, const RelativeMotion<T>& r,
               const T* known, const T* states, T* next, ScalarEquation<T>* out) {
  using Kind = ConstraintData::Kind;
  switch (c.kind) {
    case Kind::coupling: {
      const ScalarEquation<T> e = coordinate<T>(term.joint, joint_info(term.joint).velocities, term.local, r,
                                                known, term.turns < 0 ? T(0) : states[term.turns]);
      if (term.turns >= 0) next[term.turns] = e.value;
      out[0] = T(term.factor) * e;
      return;
    }
    case Kind::distance:
      out[0] = distance<T>(r, T(c.constant));
      return;
    case Kind::on_line:
      out[0] = along_axis<T>(r, 0);
      out[1] = along_axis<T>(r, 1);
      return;
    case Kind::on_plane:
      out[0] = along_axis<T>(r, 2);
      return;
    case Kind::on_curve:
      next[0] = on_curve<T>(c.curve, r, states[0], out);
      return;
    case Kind::parallel:
      out[0] = axes_product<T>(r, 0, 2);
      out[1] = axes_product<T>(r, 1, 2);
      return;
    case Kind::perpendicular:
      out[0] = axes_product<T>(r, 2, 2);
      return;
    case Kind::constant_velocity:
      // Shafts that turn alike: what turns a's axes to b's is a turn about an axis at right angles to the
      // shaft, that is, the rotation's skew part has no component along z.
      for (int axis = 0; axis < 3; ++axis) out[axis] = along_axis<T>(r, axis);
      out[3] = T(0.5) * (axes_product<T>(r, 1, 0) - axes_product<T>(r, 0, 1));
      return;
    case Kind::screw: {
      out[0] = along_axis<T>(r, 0);
      out[1] = along_axis<T>(r, 1);
      out[2] = axes_product<T>(r, 0, 2);
      out[3] = axes_product<T>(r, 1, 2);
      const ScalarEquation<T> turn = coordinate<T>(spec::JointType::cylindrical, 2, 0, r, nullptr, states[0]);
      next[0] = turn.value;
      out[4] = along_axis<T>(r, 2) - T(c.constant) * turn;
      return;
    }
  }
}

/// Most equations that one has.
constexpr int most_equations = 6;

}  // namespace mimbre::constraints
