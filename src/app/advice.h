#pragma once
#include "mimbre/simulation.h"

namespace mimbre::app {

/// One line to stderr where another formulation would be much faster: "mimbre: note: …".
void print_advice(const Simulation& simulation);

}  // namespace mimbre::app
