#pragma once
#include "joints/motion.h"

namespace mimbre {

/// Rotation q0 about z, translation q1 along z.
template <class T>
void cylindrical_motion(const T* q, const T*, JointMotion<T>& m) {
  m.rotation = rotation_z(q[0]);
  m.displacement[2] = q[1];
  m.angular(2, 0) = T(1);
  m.linear(2, 1) = T(1);
}

/// The angle, within ±π, and the displacement along z.
template <class T>
void cylindrical_coordinates(const Mat3<T>& rotation, const Vec3<T>& displacement, T* q) {
  q[0] = turn_about_z(rotation);
  q[1] = displacement[2];
}

}  // namespace mimbre
