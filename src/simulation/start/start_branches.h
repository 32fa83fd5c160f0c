#pragma once
#include <string>

#include "dynamics/relative/system.h"
#include "dynamics/state.h"

namespace mimbre {

/// In a singular position (a parallelogram lying flat) a mechanism can go several ways, and velocities that
/// keep the constraints to first order may be those of none: Φq a = −Φ̇q v then has no solution, and the first
/// step makes up for it by an impact. Reports that, with the joint; empty where the accelerations of the
/// state keep its constraints. Changes the system's last evaluation.
std::string explain_branches(relative::RelativeSystem& system, const State& state);

}  // namespace mimbre
