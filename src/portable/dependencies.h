#pragma once
#include <vector>

#include "portable/record.h"

namespace mimbre::portable {

/// For each output the inputs of the model (their numbers, ascending) whose value of now it shows at once,
/// not only by what a step makes of them: what is fed through.
std::vector<std::vector<int>> inputs_of_outputs(const RecordedModel& recorded, const SignalsData& signals);

/// For each output whether it shows accelerations or multipliers, which all forces decide.
std::vector<bool> outputs_by_acceleration(const RecordedModel& recorded, const SignalsData& signals);

/// The equations in which an input of the model is, ascending.
std::vector<int> equations_of_inputs(const RecordedModel& recorded, const SignalsData& signals);

/// Whether a signal that forces may follow shows accelerations or multipliers.
bool signals_see_accelerations(const RecordedModel& recorded, const SignalsData& signals);

}  // namespace mimbre::portable
