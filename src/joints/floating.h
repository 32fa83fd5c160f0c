#pragma once
#include "joints/joint_kind.h"
#include "joints/motion.h"

namespace mimbre::joints {

/// Position q0..q2 in a's axes, unit quaternion q3..q6; velocity coordinates: velocity of b's origin in a's
/// axes, relative angular velocity in b's axes.
struct Floating {
  static constexpr JointInfo info{.type = spec::JointType::floating,
                                  .name = "floating",
                                  .elsewhere = "free",
                                  .velocities = 6,
                                  .positions = 7,
                                  .quaternion = 3,
                                  .rotation = 3,
                                  .lengths = 0b000111,
                                  .moves = "xyz",
                                  .any_place = true};

  template <class T>
  static void motion(const T* q, const T*, JointMotion<T>& m) {
    m.rotation = rotation_matrix<T>(Quat<T>(q[3], q[4], q[5], q[6]));
    m.displacement = Vec3<T>(q[0], q[1], q[2]);
    m.linear.template leftCols<3>().setIdentity();
    m.angular.template rightCols<3>() = m.rotation;
  }

  /// The displacement and the quaternion.
  template <class T>
  static void coordinates(const Mat3<T>& rotation, const Vec3<T>& displacement, T* q) {
    const Quat<T> turn = quaternion_of(rotation);
    for (int k = 0; k < 3; ++k) q[k] = displacement[k];
    for (int k = 0; k < 4; ++k) q[3 + k] = turn[k];
  }
};

}  // namespace mimbre::joints
