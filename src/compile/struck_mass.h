#pragma once
#include "compile/compiled.h"

namespace mimbre {

/// The mass that an impact between the two frames of an element moves, kg: of both bodies as if free, with
/// their turning and their modes, as a mean over the directions.
double struck_mass(const Compiled& model, const ElementData& element);

/// The least of these of all pairs of a swarm's spheres. Infinite where there are none.
double struck_mass(const Compiled& model, const SwarmData& swarm);

}  // namespace mimbre
