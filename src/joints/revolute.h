#pragma once
#include "joints/motion.h"

namespace mimbre {

/// Rotation q0 about z.
template <class T>
void revolute_motion(const T* q, const T*, JointMotion<T>& m) {
  m.rotation = rotation_z(q[0]);
  m.angular(2, 0) = T(1);
}

/// The angle, within ±π.
template <class T>
void revolute_coordinates(const Mat3<T>& rotation, const Vec3<T>&, T* q) {
  q[0] = turn_about_z(rotation);
}

}  // namespace mimbre
