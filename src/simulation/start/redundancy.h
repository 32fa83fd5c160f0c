#pragma once
#include "dynamics/relative/system.h"
#include "dynamics/state.h"
#include "mimbre/simulation.h"

namespace mimbre {

/// Equations that depend on others in the state's position, and the joints through which forces can go round
/// without load. Changes the system's factorisation and its last evaluation.
Redundancy find_redundancy(relative::RelativeSystem& system, const State& state);

}  // namespace mimbre
