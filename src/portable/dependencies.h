#pragma once
#include <vector>

#include "portable/record.h"

namespace mimbre::portable {

/// The values that a number is computed from directly, without a step or a solution in between.
struct Dependencies {
  std::vector<int> inputs;  ///< of the model, by number, ascending
  bool time = false;        ///< explicitly: a function of time, or in an instant's code a position by a drive
  bool motion = false;      ///< positions or velocities
  bool memory = false;      ///< states of controllers and force elements
  bool acceleration = false;  ///< accelerations or multipliers, which depend on all forces
};

/// Of each output.
std::vector<Dependencies> dependencies_of_outputs(const RecordedModel& recorded, const SignalsData& signals);

/// The equations that depend on an input of the model, ascending.
std::vector<int> equations_of_inputs(const RecordedModel& recorded, const SignalsData& signals);

/// Whether a signal that a force may follow depends on accelerations or multipliers.
bool signals_see_accelerations(const RecordedModel& recorded, const SignalsData& signals);

}  // namespace mimbre::portable
