#pragma once
#include "mimbre/reduced_body.h"

namespace mimbre {

/// Whether displacements are linear in the amplitudes.
inline bool is_linear(const ReducedBody& body) { return !body.second_order && !body.ancf; }

}  // namespace mimbre
