#pragma once
#include "joints/joint_kind.h"
#include "joints/motion.h"

namespace mimbre::joints {

/// Translation q0 along z.
struct Prismatic {
  static constexpr JointInfo info{
      .type = spec::JointType::prismatic,
      .name = "prismatic",
      .elsewhere = "slider translational",
      .velocities = 1,
      .positions = 1,
      .lengths = 0b1,
      .moves = "z",
      .equations = 5,
      .closure = {closure::dx, closure::dy, closure::xy, closure::yz, closure::zx},
      .given = {2, -1},
      .vectors = 0b110};

  template <class T>
  static void motion(const T* q, const T*, JointMotion<T>& m) {
    m.displacement[2] = q[0];
    m.linear(2, 0) = T(1);
  }

  /// The displacement along z.
  template <class T>
  static void coordinates(const Mat3<T>&, const Vec3<T>& displacement, T* q) {
    q[0] = displacement[2];
  }
};

}  // namespace mimbre::joints
