#pragma once
#include <array>

#include "compile/compiled.h"
#include "forces/surfaces/touch.h"

namespace mimbre::surfaces {

/// `size`: edges.
template <class T>
Touch<T> box(const SurfaceData& s, const Vec3<T>& p) {
  std::array<T, 3> out;
  std::array<Vec3<T>, 3> normals;
  for (int k = 0; k < 3; ++k) {
    const T side = select(p[k] < T(0), T(-1), T(1));
    out[static_cast<std::size_t>(k)] = side * p[k] - T(0.5 * s.size[k]);
    normals[static_cast<std::size_t>(k)] = side * Vec3<T>::Unit(k);
  }
  return convex<3>(out, normals);
}

}  // namespace mimbre::surfaces
