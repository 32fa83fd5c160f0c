#pragma once
#include "integrate/stepper.h"

namespace mimbre {

/// About how fast the fastest motion is that the forces at a state allow, 1/s: ω of what vibrates, d of what
/// dampers stop. For messages: it allocates and leaves the system evaluated elsewhere. 0: unknown.
double fastest_motion(System& system, const State& state);

/// |λ| h up to which motions that vibrate or decay stay bounded with an explicit rule.
double stable_reach(spec::Simulation::Integrator rule);

}  // namespace mimbre
