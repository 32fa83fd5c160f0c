#pragma once
#include <string>
#include <vector>

#include "compile/compiled.h"

namespace mimbre {

/// What signals and force elements are in an evaluation, copied from a workspace: slots of SignalValues, and
/// the storage of ElementState.
struct SeenByLaws {
  std::vector<double> signals, elements;
};

/// A law that jumps with the motion (sign, a comparison, a choice) about where an iteration that did not
/// converge has been: "signal 'brake'", "spring 'stop'" and between what it jumps. Empty: there is none.
/// `start`: where the step starts; `last`: of its last iteration. Laws are followed along the straight line
/// through both and beyond, so that nothing has to be remembered while a step is made.
std::string jumping_law(const Compiled& model, const SeenByLaws& start, const SeenByLaws& last);

}  // namespace mimbre
