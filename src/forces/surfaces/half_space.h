#pragma once
#include "compile/compiled.h"
#include "forces/surfaces/touch.h"

namespace mimbre::surfaces {

/// All below z = 0.
template <class T>
Touch<T> half_space(const SurfaceData&, const Vec3<T>& p) {
  return {p[2], Vec3<T>::UnitZ()};
}

}  // namespace mimbre::surfaces
