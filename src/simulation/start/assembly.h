#pragma once
#include <map>
#include <memory>
#include <string>

#include "dynamics/natural/system.h"
#include "dynamics/relative/system.h"
#include "dynamics/state.h"
#include "integrate/statics.h"
#include "mimbre/method.h"

/// Where a mechanism starts, whatever the formulation: everything begins in relative coordinates.
namespace mimbre {

/// What is given of the joints' coordinates at the start, or near what they are, with loops open; signals as
/// they begin, and `system` evaluates with them. The weights (velocities × 1) determine what may move to
/// close loops: the scale of the coordinate, or 0 for what is given and for modes.
State given_state(const Compiled& model, relative::RelativeSystem& system,
                  const std::map<std::string, double>& inputs, Eigen::VectorXd& position_weight,
                  Eigen::VectorXd& velocity_weight);

/// Loops closed, velocities consistent, what the user gave kept; accelerations and multipliers zero; signals
/// and force elements as they begin, with these inputs, which `system` evaluates from now on, as long as the
/// state is there. Throws InputError when the loops do not close or the given initial values contradict each
/// other.
State assembled_state(const Compiled& model, relative::RelativeSystem& system,
                      const std::map<std::string, double>& inputs = {});

/// The system of natural coordinates where the method asks for it, else nothing.
std::unique_ptr<natural::NaturalSystem> make_natural(const Compiled& model, const Method& method);

/// A state in relative coordinates by points and vectors.
State natural_state(const natural::NaturalSystem& natural, relative::RelativeSystem& observer,
                    const State& relative);

/// Static equilibrium near s (relative coordinates), found in natural coordinates if there is such a system.
StaticsStatus equilibrium(natural::NaturalSystem* natural, relative::RelativeSystem& observer, State& s);

/// Moves s to its static equilibrium and keeps its velocities: the same one for both formulations, also where
/// the loads leave open which (a car's place on a level road). Throws InputError when there is none. Returns
/// a warning where it is unstable, else nothing.
std::string start_at_equilibrium(relative::RelativeSystem& system, State& s);

}  // namespace mimbre
