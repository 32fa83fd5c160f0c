#pragma once
#include <vector>

#include "mimbre/spec.h"

namespace mimbre {

/// Bodies whose geometric stiffness knows loads of inertia and that the mechanism holds on the ground at
/// places that their modes move, and not at the one where they are clamped, in the order of the model. The
/// loads then depend on the motion of the modes so strongly that a bent body may lose its mass.
std::vector<int> bodies_held_elsewhere(const spec::Model& model);

}  // namespace mimbre
