#pragma once
#include "joints/joint_kind.h"
#include "joints/motion.h"

namespace mimbre::joints {

/// Unit quaternion q0..q3; velocity coordinates: relative angular velocity in b's axes. The columns are b's
/// axes, which turn with the relative angular velocity itself, so that the bias ω×ω vanishes.
struct Spherical {
  static constexpr JointInfo info{.type = spec::JointType::spherical,
                                  .name = "spherical",
                                  .elsewhere = "ball ball_joint",
                                  .velocities = 3,
                                  .positions = 4,
                                  .quaternion = 0,
                                  .equations = 3,
                                  .closure = {closure::dx, closure::dy, closure::dz}};

  template <class T>
  static void motion(const T* q, const T*, JointMotion<T>& m) {
    m.rotation = rotation_matrix<T>(Quat<T>(q[0], q[1], q[2], q[3]));
    m.angular.template leftCols<3>() = m.rotation;
  }

  /// The quaternion.
  template <class T>
  static void coordinates(const Mat3<T>& rotation, const Vec3<T>&, T* q) {
    const Quat<T> turn = quaternion_of(rotation);
    for (int k = 0; k < 4; ++k) q[k] = turn[k];
  }
};

}  // namespace mimbre::joints
