#pragma once
#include <algorithm>

namespace mimbre {

/// How far constraints are from being fulfilled: the largest |Φ| of the equations that are lengths and of
/// those that are angles, and the largest |Φ̇| of each. Conditions between unit vectors (an axis at right
/// angles to another, natural coordinates' rigidity) count as angles: they are one to first order.
struct Violations {
  double position_violation = 0;          ///< m
  double angle_violation = 0;             ///< rad
  double velocity_violation = 0;          ///< m/s
  double angular_velocity_violation = 0;  ///< rad/s

  /// The larger of both, each.
  void raise(const Violations& other) {
    position_violation = std::max(position_violation, other.position_violation);
    angle_violation = std::max(angle_violation, other.angle_violation);
    velocity_violation = std::max(velocity_violation, other.velocity_violation);
    angular_velocity_violation = std::max(angular_velocity_violation, other.angular_velocity_violation);
  }
};

}  // namespace mimbre
