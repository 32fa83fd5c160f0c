#pragma once
#include <algorithm>
#include <cmath>

#include "compile/compiled.h"

namespace mimbre {

/// The scale of a modal amplitude by its modal mass: what gives all of the body's mass at the mechanism's
/// length the same kinetic energy, at most a hundred times that length. So it is the same motion whatever the
/// unit of the mode. Without mass, and of absolute coordinates, the length itself.
inline double modal_scale(const Compiled& m, const BodyData& body, int mode) {
  constexpr double least_mass = 1e-4;  ///< of the body's
  const FlexibleData& f = m.flexible[body.flexible];
  const double mass = f.mass(mode, mode);
  if (f.identity_mass || f.absolute() || !(body.mass > 0 && mass > 0)) return amplitude_scale(m, body);
  return m.length_scale * std::sqrt(body.mass / std::max(mass, least_mass * body.mass));
}

}  // namespace mimbre
