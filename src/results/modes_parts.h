#pragma once
#include "mimbre/modes.h"

namespace mimbre::results {

/// Throws std::invalid_argument where the modes were found without.
const MechanismShapes& shapes_of(const LinearisedModes& modes);

/// "rigid", "real", "oscillating".
const char* kind_name(const Mode& mode);

}  // namespace mimbre::results
