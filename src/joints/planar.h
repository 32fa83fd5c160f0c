#pragma once
#include "joints/joint_kind.h"
#include "joints/motion.h"

namespace mimbre::joints {

/// Translations q0, q1 along a's x and y, rotation q2 about z.
struct Planar {
  static constexpr JointInfo info{.type = spec::JointType::planar,
                                  .name = "planar",
                                  .elsewhere = "plane",
                                  .velocities = 3,
                                  .positions = 3,
                                  .lengths = 0b011,
                                  .moves = "xyz",
                                  .equations = 3,
                                  .closure = {closure::dz, closure::xz, closure::yz},
                                  .given = {2, -1},
                                  .implied = true,
                                  .vectors = 0b011};

  template <class T>
  static void motion(const T* q, const T*, JointMotion<T>& m) {
    m.rotation = rotation_z(q[2]);
    m.displacement[0] = q[0];
    m.displacement[1] = q[1];
    m.linear(0, 0) = T(1);
    m.linear(1, 1) = T(1);
    m.angular(2, 2) = T(1);
  }

  /// The displacements along x and y, and the angle within ±π.
  template <class T>
  static void coordinates(const Mat3<T>& rotation, const Vec3<T>& displacement, T* q) {
    q[0] = displacement[0];
    q[1] = displacement[1];
    q[2] = turn_about_z(rotation);
  }
};

}  // namespace mimbre::joints
