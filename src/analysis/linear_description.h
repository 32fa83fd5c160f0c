#pragma once
#include "analysis/linear_point.h"
#include "dynamics/system.h"

/// What a linear model says in words: names of its variables, the motion at its point, and what to beware of.
namespace mimbre::linear {

constexpr double still = 1e-9;  ///< of the mechanism's rates: at rest

/// The mechanism's rate at these velocities, 1/s; 1 where it has none.
double pace_of(const System& system, const Eigen::VectorXd& velocities);
/// The largest work of one force element at rest along the scales, J: of what balances, if anything does.
double work_of_forces(const Compiled& model, relative::RelativeSystem& system, const State& state);
/// Fills in out.names but the point, and the axes in which coefficients are constant along the motion.
void describe(const Compiled& model, relative::RelativeSystem& system, Linearised& out);

}  // namespace mimbre::linear
