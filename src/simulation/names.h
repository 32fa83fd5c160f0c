#pragma once
#include <string>

#include "dynamics/natural/system.h"
#include "integrate/stepper.h"
#include "simulation/energy.h"

/// What numbers of the step are called, for messages.
namespace mimbre {

/// Where a velocity coordinate belongs: "joint 'x'", "mode 2 of body 'arm'"; in natural coordinates (given
/// `natural`) the body. "the model" when the number is none.
std::string coordinate_name(const Compiled& model, const natural::NaturalSystem* natural, int coordinate);

/// The joint, drive or body that must stay rigid that a constraint equation belongs to.
std::string equation_name(const Compiled& model, const natural::NaturalSystem* natural, int equation);

/// "spring 'front'".
std::string element_name(const Compiled& model, const ElementData& element);

/// What stores energy.
std::string place_name(const Compiled& model, const EnergyMeter::Place& place);

}  // namespace mimbre
