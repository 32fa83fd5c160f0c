#pragma once
#include "joints/joint_kind.h"
#include "joints/motion.h"

namespace mimbre::joints {

/// Rotation q0 about z.
struct Revolute {
  static constexpr JointInfo info{
      .type = spec::JointType::revolute,
      .name = "revolute",
      .elsewhere = "hinge pin rotational",
      .velocities = 1,
      .positions = 1,
      .moves = "z",
      .equations = 5,
      .closure = {closure::dx, closure::dy, closure::dz, closure::xz, closure::yz},
      .given = {2, -1}};

  template <class T>
  static void motion(const T* q, const T*, JointMotion<T>& m) {
    m.rotation = rotation_z(q[0]);
    m.angular(2, 0) = T(1);
  }

  /// The angle, within ±π.
  template <class T>
  static void coordinates(const Mat3<T>& rotation, const Vec3<T>&, T* q) {
    q[0] = turn_about_z(rotation);
  }
};

}  // namespace mimbre::joints
