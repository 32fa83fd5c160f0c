#pragma once
#include "mimbre/spec.h"

namespace mimbre {

/// Bodies that bend by linear elastodynamics move as if they were rigid: their joints stay where the rigid
/// body has them. Their modes are therefore made those that a frame carried by the joints sees, the rigid
/// motion nearest to what a mode does at the joints taken off (a bar between two pins bends between these,
/// though its modes may be those of one that is clamped at an end), and orthogonal. Nothing changes where the
/// modes are such already. Throws InputError where that leaves too little of them.
void set_elastodynamic_modes(spec::Model& model);

}  // namespace mimbre
