#pragma once
#include <string>

#include "dynamics/state.h"
#include "mimbre/method.h"

namespace mimbre {

struct Compiled;

/// Of a step to `t` that did not converge: whether a drive asks for a position at which loops and constraints
/// do not close, so that no step could get there, and which. Otherwise empty. `state`: where the step began,
/// in relative coordinates. For people.
std::string explain_drive_limit(const Compiled& model, const Method& method, const State& state, double t);

}  // namespace mimbre
