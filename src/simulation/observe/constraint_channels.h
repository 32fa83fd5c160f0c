#pragma once
#include <vector>

#include "dynamics/relative/system.h"
#include "dynamics/state.h"
#include "mimbre/channels.h"

/// What constraints carry.
namespace mimbre {

/// Force and moment that a constraint exerts on its second side, the moment about the origin of the frame
/// there, global axes; after a residual with the state's accelerations and multipliers.
Wrench<double> constraint_wrench(const ConstraintData& constraint, const relative::RelativeSystem& system,
                                 const State& state);

/// The standard channels of a constraint: of a coupling the force or torque on each of its coordinates, of
/// others what its kind carries of constraint_wrench().
void add_constraint_info(const Compiled& model, const ConstraintData& constraint,
                         std::vector<ChannelInfo>& channels);
/// Their values, in the same order.
void read_constraint(const ConstraintData& constraint, const relative::RelativeSystem& system,
                     const State& state, double* values);

}  // namespace mimbre
