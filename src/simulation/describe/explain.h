#pragma once
#include <string>
#include <vector>

#include "dynamics/natural/system.h"
#include "integrate/statics.h"
#include "mimbre/simulation.h"
#include "simulation/observe/smallest_reactions.h"
#include "simulation/step/mechanism.h"

namespace mimbre {

/// What went wrong in the step to `t`, and where, for people. `jump`: of a step that did not converge the law
/// that jumps (jumping_law), if any, `meaningless` a body that is bent too far (ValidityMonitor) or a drive
/// that cannot be followed (explain_drive_limit). `stable`: of one too long for an explicit integrator the
/// longest stable step, s; 0: unknown.
std::string explain(const Mechanism& mechanism, const StepReport& report, double t, const std::string& jump,
                    const std::string& meaningless, double stable);

/// The constraint, joint or drive whose equation was not a number when the system was evaluated last, and why
/// as far as that is known; empty: none.
std::string explain_lost_constraint(const Mechanism& mechanism);

/// Of a step that did not converge: a drive and what else holds the motion that it prescribes, if any.
std::string explain_contradiction(const Compiled& model, const Redundancy& redundancy);

/// Why the accelerations at the start are not determined: the bodies that move without mass, or the
/// coordinate, -1: unknown, whose inertia is round-off, and what to do.
std::string explain_undetermined_start(const Compiled& model, const natural::NaturalSystem* natural,
                                       int coordinate);

/// Why a static equilibrium was not found: what is not balanced, and where.
std::string explain_imbalance(const Compiled& model, const natural::NaturalSystem* natural,
                              const StaticsStatus& status);

/// A warning of laws that are called at instants alone, which act in no equilibrium; empty: there are none.
std::string explain_sampled_laws(const Compiled& model);

/// A warning where an equilibrium does not last, else nothing.
std::string explain_instability(const Compiled& model, const natural::NaturalSystem* natural,
                                const StaticsStatus& status);

/// A warning where constraints are nearly redundant, else nothing.
std::string explain_near_redundancy(const Redundancy& redundancy);

/// A warning of bodies by elastodynamics (numbers in the model) that reactions bend which redundant joints
/// leave open, else nothing.
std::string explain_open_bending(const Compiled& model, const std::vector<int>& bodies,
                                 const Redundancy& redundancy);

/// A warning of bodies with geometric stiffness that are held elsewhere than where they are clamped (numbers
/// in the model), else nothing.
std::string explain_held_elsewhere(const spec::Model& model, const std::vector<int>& bodies);

/// Of a velocity coordinate that is a mode of a body that loads of inertia stiffen: how these may take the
/// body's mass away. Of others nothing.
std::string explain_lost_mass(const Compiled& model, const natural::NaturalSystem* natural, int coordinate);

/// A warning of reactions that a run does not resolve.
std::string explain_unresolved(const Compiled& model, const UnresolvedReaction& reaction);

}  // namespace mimbre
