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

}  // namespace mimbre
