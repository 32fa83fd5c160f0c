#pragma once
#include "constraints/equation_context.h"
#include "joints/axes.h"
#include "math/turn.h"

namespace mimbre::constraints {

/// Both origins coincide, and a turn about a's z makes b turn as much about its z.
struct ConstantVelocity {
  /// Those of b are those of a, bent with the shafts.
  static ConstraintInfo::Axes frame_axes(const Eigen::Vector3d& first, const Eigen::Vector3d& second) {
    const Eigen::Matrix3d a = axes_with_z(first);
    return {a, turn_between(first, second) * a};
  }
  static std::string_view axes_fault(const Eigen::Vector3d& first, const Eigen::Vector3d& second) {
    return first.dot(second) > -1 + 1e-9 ? ""
                                         : "the shafts point against each other; turn one of the axes round";
  }
  static constexpr ConstraintInfo info{.name = "constant_velocity",
                                       .equations = 4,
                                       .lengths = 0b0111,
                                       .force = true,
                                       .moment = true,
                                       .axes = 2,
                                       .frame_axes = frame_axes,
                                       .axes_fault = axes_fault};

  /// Shafts that turn alike: what turns a's axes to b's is a turn about an axis at right angles to the shaft,
  /// that is, the rotation's skew part has no component along z.
  template <class T>
  static void equations(const EquationContext<T>& c, ScalarEquation<T>* out) {
    for (int axis = 0; axis < 3; ++axis) out[axis] = along_axis<T>(c.motion, axis);
    out[3] = T(0.5) * (axes_product<T>(c.motion, 1, 0) - axes_product<T>(c.motion, 0, 1));
  }
};

}  // namespace mimbre::constraints
