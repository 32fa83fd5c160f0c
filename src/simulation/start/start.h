#pragma once
#include <map>
#include <string>
#include <vector>

#include "mimbre/simulation.h"
#include "simulation/step/mechanism.h"

namespace mimbre {

/// What was found out about a mechanism where it starts.
struct Start {
  std::vector<std::string> warnings;
  Redundancy redundancy;
};

/// Puts a mechanism where it starts: loops closed, consistent velocities, the equilibrium if asked for,
/// accelerations. Throws InputError when the loops do not close, the given initial values contradict each
/// other, or there is no such input. `inputs`: RunOptions::inputs; `warns`: also looks for what is worth a
/// warning and nothing else.
Start start(Mechanism& mechanism, const Method& method, const std::map<std::string, double>& inputs,
            bool warns);

}  // namespace mimbre
