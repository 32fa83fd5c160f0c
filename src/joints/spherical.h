#pragma once
#include "joints/motion.h"

namespace mimbre {

/// Unit quaternion q0..q3; velocity coordinates: relative angular velocity in b's axes. The columns are b's
/// axes, which turn with the relative angular velocity itself, so that the bias ω×ω vanishes.
template <class T>
void spherical_motion(const T* q, const T*, JointMotion<T>& m) {
  m.rotation = rotation_matrix<T>(Quat<T>(q[0], q[1], q[2], q[3]));
  m.angular.template leftCols<3>() = m.rotation;
}

/// The quaternion.
template <class T>
void spherical_coordinates(const Mat3<T>& rotation, const Vec3<T>&, T* q) {
  const Quat<T> turn = quaternion_of(rotation);
  for (int k = 0; k < 4; ++k) q[k] = turn[k];
}

}  // namespace mimbre
