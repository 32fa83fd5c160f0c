#pragma once
#include <memory>
#include <string>

#include "mimbre/simulation.h"

/// Simulations of small models, and what their channels say.
namespace mimbre::test {

using Formulation = spec::Simulation::Formulation;

/// `step`: s; 0: the model's.
Simulation simulation_of(const std::shared_ptr<const Model>& model, Formulation formulation, double step = 0);
/// Of a model file's text (support/models.h).
Simulation simulation_of(const std::string& text, Formulation formulation, double step = 0);

/// With less damping and smaller errors of the iterations than by default: what is left is the rule's.
Simulation precise_simulation_of(const std::string& text, Formulation formulation, double step);

/// Steps to that time, s; a failure where a step fails.
void run_to(Simulation& simulation, double end);

/// The channel of that name now; a failure where there is none.
double channel(Simulation& simulation, const std::string& name);

}  // namespace mimbre::test
