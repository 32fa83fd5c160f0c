#pragma once
#include "math/rotation.h"

namespace mimbre {

/// Motion of a flexible body in its own axes, as far as it stresses the body (GeometricStiffness).
template <class T>
struct StressMotion {
  Vec3<T> omega;         ///< angular velocity of the body frame
  Vec3<T> acceleration;  ///< at the origin, minus gravity: of the body's mean motion, as `alpha`
  Vec3<T> alpha;
};

}  // namespace mimbre
