#pragma once
#include <vector>

#include "mimbre/channels.h"

namespace mimbre {

/// The sections of bodies of bars that the model's outputs ask for, as the reductions order them. Outputs are
/// the first of the channels, in their order.
std::vector<RecordedSection> recorded_sections(const spec::Model& model);

}  // namespace mimbre
