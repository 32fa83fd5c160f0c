#pragma once
#include <vector>

#include "portable/record.h"

namespace mimbre::portable {

/// For each output the inputs of the model (their numbers, ascending) whose value of now it shows at once,
/// not only by what a step makes of them: what is fed through.
std::vector<std::vector<int>> inputs_of_outputs(const RecordedModel& recorded, const SignalsData& signals);

}  // namespace mimbre::portable
