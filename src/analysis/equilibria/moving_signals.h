#pragma once
#include <string>
#include <vector>

#include "dynamics/relative/system.h"
#include "dynamics/state.h"

namespace mimbre {

/// Names of signals that would not stay where the mechanism rests: an equilibrium is found with what they
/// remember at the start, and filters, controllers and sampled signals may go on from there.
std::vector<std::string> moving_signals(const Compiled& model, relative::RelativeSystem& system,
                                        const State& rest);

}  // namespace mimbre
