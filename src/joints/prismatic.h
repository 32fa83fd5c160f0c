#pragma once
#include "joints/motion.h"

namespace mimbre {

/// Translation q0 along z.
template <class T>
void prismatic_motion(const T* q, const T*, JointMotion<T>& m) {
  m.displacement[2] = q[0];
  m.linear(2, 0) = T(1);
}

}  // namespace mimbre
