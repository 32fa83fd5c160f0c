#pragma once
#include "mimbre/spec.h"

namespace mimbre {

/// Whether a joint's coordinate (or its rate), that is given at the start, is another one than that of its
/// drive: by more than round-off of either, and of what is neither small nor large in the model as it is
/// drawn.
bool contradicts_drive(const spec::Model& model, spec::JointType type, int coordinate, bool rate,
                       double given, double driven);

}  // namespace mimbre
