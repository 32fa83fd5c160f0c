#pragma once
#include "joints/motion.h"

namespace mimbre {

/// Position q0..q2 in a's axes, unit quaternion q3..q6; velocity coordinates: velocity of b's origin in a's
/// axes, relative angular velocity in b's axes.
template <class T>
void floating_motion(const T* q, const T*, JointMotion<T>& m) {
  m.rotation = rotation_matrix<T>(Quat<T>(q[3], q[4], q[5], q[6]));
  m.displacement = Vec3<T>(q[0], q[1], q[2]);
  m.linear.template leftCols<3>().setIdentity();
  m.angular.template rightCols<3>() = m.rotation;
}

/// The displacement and the quaternion.
template <class T>
void floating_coordinates(const Mat3<T>& rotation, const Vec3<T>& displacement, T* q) {
  const Quat<T> turn = quaternion_of(rotation);
  for (int k = 0; k < 3; ++k) q[k] = displacement[k];
  for (int k = 0; k < 4; ++k) q[3 + k] = turn[k];
}

}  // namespace mimbre
