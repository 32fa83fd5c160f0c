#pragma once
#include "joints/motion.h"

namespace mimbre {

/// Translations q0, q1 along a's x and y, rotation q2 about z.
template <class T>
void planar_motion(const T* q, const T*, JointMotion<T>& m) {
  m.rotation = rotation_z(q[2]);
  m.displacement[0] = q[0];
  m.displacement[1] = q[1];
  m.linear(0, 0) = T(1);
  m.linear(1, 1) = T(1);
  m.angular(2, 2) = T(1);
}

}  // namespace mimbre
