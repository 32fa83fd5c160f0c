#pragma once
#include <algorithm>
#include <cmath>

#include "compile/compiled.h"

namespace mimbre {

/// The scale of a modal amplitude by its modal mass: what gives all of the body's mass at the mechanism's
/// length the same kinetic energy, at most a hundred times that length. So it is the same motion whatever the
/// unit of the mode. Of orthonormal modes and without mass: amplitude_scale().
inline double scale_by_modal_mass(const Compiled& m, const BodyData& body, int mode) {
  constexpr double least_mass = 1e-4;  ///< of the body's
  const FlexibleData& f = m.flexible[body.flexible];
  const double mass = f.mass(mode, mode);
  if (f.identity_mass || !(body.mass > 0 && mass > 0)) return amplitude_scale(m, body);
  return m.length_scale * std::sqrt(body.mass / std::max(mass, least_mass * body.mass));
}

/// The same in steps and searches, where absolute coordinates are measured by the length itself.
inline double modal_scale(const Compiled& m, const BodyData& body, int mode) {
  return m.flexible[body.flexible].absolute() ? amplitude_scale(m, body) : scale_by_modal_mass(m, body, mode);
}

}  // namespace mimbre
