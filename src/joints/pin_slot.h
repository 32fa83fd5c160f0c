#pragma once
#include "joints/joint_kind.h"
#include "joints/motion.h"

namespace mimbre::joints {

/// A pin in a slot: translation q0 along a's x, the slot, and rotation q1 about z, the pin.
struct PinSlot {
  static constexpr JointInfo info{.type = spec::JointType::pin_slot,
                                  .name = "pin_slot",
                                  .velocities = 2,
                                  .positions = 2,
                                  .lengths = 0b01,
                                  .moves = "xz",
                                  .equations = 4,
                                  .closure = {closure::dy, closure::dz, closure::xz, closure::yz},
                                  .given = {2, 0},
                                  .vectors = 0b011};

  template <class T>
  static void motion(const T* q, const T*, JointMotion<T>& m) {
    m.displacement[0] = q[0];
    m.rotation = rotation_z(q[1]);
    m.linear(0, 0) = T(1);
    m.angular(2, 1) = T(1);
  }

  /// The displacement along x and the angle, within ±π.
  template <class T>
  static void coordinates(const Mat3<T>& rotation, const Vec3<T>& displacement, T* q) {
    q[0] = displacement[0];
    q[1] = turn_about_z(rotation);
  }
};

}  // namespace mimbre::joints
