#pragma once
#include <algorithm>
#include <cmath>

#include "compile/compiled.h"
#include "dynamics/scales.h"

namespace mimbre::linear {

/// The scale of a modal amplitude by its modal mass: what gives all of the body's mass at the mechanism's
/// length the same kinetic energy, at most a hundred times that length. `otherwise`: of orthonormal modes,
/// whose scale is that already, and without mass.
inline double modal_scale(const Compiled& m, const BodyData& body, int mode, double otherwise) {
  constexpr double least_mass = 1e-4;  ///< of the body's
  const FlexibleData& f = m.flexible[body.flexible];
  const double mass = f.mass(mode, mode);
  if (f.identity_mass || !(body.mass > 0 && mass > 0)) return otherwise;
  return m.length_scale * std::sqrt(body.mass / std::max(mass, least_mass * body.mass));
}

/// The mechanism's scales with these. What linear analyses take for round-off is then the same of similar
/// mechanisms, whatever the units of their modes.
inline Scales modal_scales(const Compiled& m, const Scales& given) {
  Scales scales = given;
  for (const BodyData& b : m.bodies)
    for (int k = 0; k < b.modes; ++k) {
      double& scale = scales.coordinates[static_cast<std::size_t>(b.v + b.joint_velocities + k)];
      scale = modal_scale(m, b, k, scale);
    }
  return scales;
}

}  // namespace mimbre::linear
