#pragma once
#include <string>

#include "dynamics/natural/system.h"
#include "mimbre/simulation.h"

namespace mimbre {

/// What went wrong in the step to `t`, and where, for people. `natural`: the system in natural coordinates
/// where it made the step, else null.
std::string explain(const Compiled& model, const natural::NaturalSystem* natural, const StepReport& report,
                    double t);

}  // namespace mimbre
