#pragma once
#include "compile/compiled.h"
#include "dynamics/modal_scale.h"
#include "dynamics/scales.h"

namespace mimbre::linear {

/// The mechanism's scales with those of all modal amplitudes by their modal mass, absolute coordinates too.
/// What linear analyses take for round-off is then the same of similar mechanisms, whatever the units of
/// their modes.
inline Scales modal_scales(const Compiled& m, const Scales& given) {
  Scales scales = given;
  for (const BodyData& b : m.bodies)
    for (int k = 0; k < b.modes; ++k)
      scales.coordinates[static_cast<std::size_t>(b.v + b.joint_velocities + k)] =
          scale_by_modal_mass(m, b, k);
  return scales;
}

}  // namespace mimbre::linear
