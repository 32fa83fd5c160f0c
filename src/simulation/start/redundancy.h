#pragma once
#include <vector>

#include "dynamics/relative/system.h"
#include "dynamics/state.h"
#include "mimbre/simulation.h"

namespace mimbre {

/// Equations that depend on others in the state's position, and the joints through which forces can go round
/// without load. Changes the system's factorisation and its last evaluation.
Redundancy find_redundancy(relative::RelativeSystem& system, const State& state);

/// Bodies by elastodynamics (numbers in the model) that bend by forces which go round so: rigid bodies do not
/// determine by how much. Likewise.
std::vector<int> bodies_of_open_bending(relative::RelativeSystem& system, const State& state);

}  // namespace mimbre
