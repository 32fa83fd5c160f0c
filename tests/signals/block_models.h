#pragma once
#include <string>

#include "mimbre/simulation.h"

/// Small models in which blocks and events are looked at.
namespace mimbre::test {

/// A mass of 1 kg on a guide along x, which gravity does not move, and what is put behind; its outputs are
/// place, speed and rise.
std::string slider(const std::string& more, double step, double end = 1);

/// A simulation of a model file's text.
Simulation simulation_of(const std::string& text, spec::Simulation::Formulation formulation);

/// What is said of a bad one.
std::string refusal_of(const std::string& text);

}  // namespace mimbre::test
