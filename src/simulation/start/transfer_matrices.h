#pragma once
#include "compile/compiled.h"
#include "mimbre/method.h"

namespace mimbre {

/// Throws InputError, with what is in the way, where the formalism transfer_matrices cannot follow the
/// mechanism: in natural coordinates, which have no order among bodies, and with contacts between spheres of
/// a swarm, whose partners change from step to step.
void refuse_transfer_matrices(const Compiled& model, const Method& method);

}  // namespace mimbre
