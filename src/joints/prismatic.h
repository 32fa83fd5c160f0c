#pragma once
#include "joints/motion.h"

namespace mimbre {

/// Translation q0 along z.
template <class T>
void prismatic_motion(const T* q, const T*, JointMotion<T>& m) {
  m.displacement[2] = q[0];
  m.linear(2, 0) = T(1);
}

/// The displacement along z.
template <class T>
void prismatic_coordinates(const Mat3<T>&, const Vec3<T>& displacement, T* q) {
  q[0] = displacement[2];
}

}  // namespace mimbre
