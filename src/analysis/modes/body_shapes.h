#pragma once
#include <vector>

#include "analysis/linear_point.h"
#include "mimbre/modes.h"

namespace mimbre::linear {

/// How the mechanism is drawn at the point, and how the modes move its bodies, by Mode::motion.
MechanismShapes body_shapes(const Linearised& at, const std::vector<Mode>& modes);

}  // namespace mimbre::linear
