#pragma once
#include "joints/joint_kind.h"
#include "joints/motion.h"
#include "math/elementary.h"

namespace mimbre::joints {

/// Rotation q0 about a's x, then q1 about b's y: R = Rx(q0) Ry(q1).
struct Universal {
  static constexpr JointInfo info{.type = spec::JointType::universal,
                                  .name = "universal",
                                  .elsewhere = "cardan hooke",
                                  .velocities = 2,
                                  .positions = 2,
                                  .moves = "xy",
                                  .biased = true,
                                  .equations = 4,
                                  .closure = {closure::dx, closure::dy, closure::dz, closure::xy},
                                  .given = {0, 1}};

  template <class T>
  static void motion(const T* q, const T* v, JointMotion<T>& m) {
    using mimbre::cos, mimbre::sin;
    const T c0 = cos(q[0]), s0 = sin(q[0]), c1 = cos(q[1]), s1 = sin(q[1]);
    m.rotation << c1, T(0), s1,  //
        s0 * s1, c0, -s0 * c1,   //
        -c0 * s1, s0, c0 * c1;
    m.angular(0, 0) = T(1);
    m.angular(1, 1) = c0;
    m.angular(2, 1) = s0;
    // d/dt (0, c0, s0) v1 = (0, −s0, c0) v0 v1
    m.angular_bias[1] = -s0 * v[0] * v[1];
    m.angular_bias[2] = c0 * v[0] * v[1];
  }

  /// The angles, within ±π: y stays at right angles to a's x, x at right angles to a's turned y.
  template <class T>
  static void coordinates(const Mat3<T>& rotation, const Vec3<T>&, T* q) {
    using mimbre::atan2;
    q[0] = atan2(rotation(2, 1), rotation(1, 1));
    q[1] = atan2(rotation(0, 2), rotation(0, 0));
  }
};

}  // namespace mimbre::joints
