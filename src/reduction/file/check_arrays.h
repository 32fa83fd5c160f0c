#pragma once
#include <string>
#include <vector>

#include "mimbre/reduced_body.h"

namespace mimbre {

/// What a step takes for granted of a body: sizes, indices, finite numbers, symmetry, positive masses. One
/// message per violation. check() asks more, which holds of matter but not of every finite element: a
/// consistent mass matrix turns a little otherwise than the bar that it stands for.
std::vector<std::string> check_arrays(const ReducedBody& body);

}  // namespace mimbre
