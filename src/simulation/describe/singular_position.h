#pragma once
#include "dynamics/relative/system.h"
#include "dynamics/state.h"

namespace mimbre {

/// Whether the loops are, in that state, near a position in which more equations depend on each other than
/// the `redundant` that always do. False, too, of large models. Changes the system's factorisation and its
/// last evaluation.
bool is_near_singular(relative::RelativeSystem& system, const State& state, int redundant);

}  // namespace mimbre
