#pragma once
#include "integrate/stepper.h"

namespace mimbre {

/// 1/s. What goes slower by the scales of the coordinates, a thousandth of them in a step of the model's,
/// counts as slow in errors of velocities: from rest, without gravity, nothing else says how fast things go.
inline double slow_motion(const IntegratorOptions& options) { return 1e-3 / options.step; }

}  // namespace mimbre
