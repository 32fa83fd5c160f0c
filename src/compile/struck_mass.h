#pragma once
#include "compile/compiled.h"

namespace mimbre {

/// The mass that an impact between the two frames of an element moves, kg: of both bodies as if free, with
/// their turning and their modes, as a mean over the directions.
double struck_mass(const Compiled& model, const ElementData& element);

/// The least mass that an impact of two spheres of a swarm moves, kg: half of its lightest body's. Infinite
/// where none has a mass.
double struck_mass(const Compiled& model, const SwarmData& swarm);

}  // namespace mimbre
