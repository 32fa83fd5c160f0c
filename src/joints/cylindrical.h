#pragma once
#include "joints/joint_kind.h"
#include "joints/motion.h"

namespace mimbre::joints {

/// Rotation q0 about z, translation q1 along z.
struct Cylindrical {
  static constexpr JointInfo info{.type = spec::JointType::cylindrical,
                                  .name = "cylindrical",
                                  .velocities = 2,
                                  .positions = 2,
                                  .lengths = 0b10,
                                  .moves = "zz",
                                  .equations = 4,
                                  .closure = {closure::dx, closure::dy, closure::xz, closure::yz},
                                  .given = {2, -1}};

  template <class T>
  static void motion(const T* q, const T*, JointMotion<T>& m) {
    m.rotation = rotation_z(q[0]);
    m.displacement[2] = q[1];
    m.angular(2, 0) = T(1);
    m.linear(2, 1) = T(1);
  }

  /// The angle, within ±π, and the displacement along z.
  template <class T>
  static void coordinates(const Mat3<T>& rotation, const Vec3<T>& displacement, T* q) {
    q[0] = turn_about_z(rotation);
    q[1] = displacement[2];
  }
};

}  // namespace mimbre::joints
