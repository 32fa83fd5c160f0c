#pragma once
#include "compile/compiled.h"
#include "forces/surfaces/touch.h"

namespace mimbre::surfaces {

/// `size`: radius.
template <class T>
Touch<T> sphere(const SurfaceData& s, const Vec3<T>& p) {
  return ball(p, T(s.size[0]));
}

}  // namespace mimbre::surfaces
