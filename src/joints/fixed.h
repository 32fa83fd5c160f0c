#pragma once
#include "joints/motion.h"

namespace mimbre {

/// No relative motion.
template <class T>
void fixed_motion(const T*, const T*, JointMotion<T>&) {}

}  // namespace mimbre
