#pragma once
#include "compile/compiled.h"
#include "forces/surfaces/touch.h"

namespace mimbre::surfaces {

/// About the z axis; `size`: radius, length between the centres of the ends.
template <class T>
Touch<T> capsule(const SurfaceData& s, const Vec3<T>& p) {
  const T half(0.5 * s.size[1]);
  const T above = select(p[2] > half, half, p[2]);
  return ball(Vec3<T>(p[0], p[1], p[2] - select(above < -half, T(-half), above)), T(s.size[0]));
}

}  // namespace mimbre::surfaces
