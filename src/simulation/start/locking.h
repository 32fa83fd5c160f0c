#pragma once
#include <string>
#include <vector>

#include "dynamics/relative/system.h"
#include "dynamics/state.h"

namespace mimbre {

/// A warning for the couplings (gears, belts, differentials) that contradict one another: joints that could
/// move without one of them, and cannot with all of them, drives apart. Changes the system's last evaluation
/// and assembly.
std::vector<std::string> locking_warnings(relative::RelativeSystem& system, const State& state);

}  // namespace mimbre
