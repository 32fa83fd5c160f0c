#pragma once
#include <string>

#include "mimbre/simulation.h"

namespace mimbre {

/// What to do where a simulation in relative coordinates would be much faster in natural ones, or by transfer
/// matrices (long open chains whose force elements couple bodies that are not neighbours, so that the matrix
/// of relative coordinates is full); else nothing.
std::string explain_slow_formulation(const Simulation& simulation);

}  // namespace mimbre
