#pragma once
#include <Eigen/Core>
#include <vector>

#include "integrate/stepper.h"

namespace mimbre {

/// Φz of the system at (t, q), dense: equations × velocities.
Eigen::MatrixXd dense_jacobian(System& system, double t, const Eigen::VectorXd& q);

/// Moves q onto the constraints with the least change of the coordinates, `weight` (velocities × 1, ≥ 0)
/// saying how readily each one moves; 0: not at all. Returns the violation that is left, max |Φ|.
/// Equations that are redundant on the constraints seem to be independent off them, by a little, and what
/// they ask for there may move the mechanism far; `caution` > 0 (30 for gaps that are small) keeps it near.
/// Where no coordinate moves any equation by more than `negligible` (m, or m per rad) they hold nothing.
double close_positions(System& system, double t, const Eigen::VectorXd& weight, Eigen::VectorXd& q,
                       double caution = 0, double negligible = 1e-13);

/// The same for velocities: Φz v = −Φt. Returns max |Φ̇|.
double close_velocities(System& system, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& weight,
                        Eigen::VectorXd& v);

/// Multipliers that balance the forces at the given motion best, of those the smallest: M a + Φzᵀ λ = Q in
/// the sense of least squares.
void find_multipliers(System& system, State& state, double negligible = 1e-13);

/// Accelerations and multipliers of the equations of motion at state.time, q, v: M a + Φzᵀ λ = Q, Φ̈ = 0.
/// False when they are not found.
bool solve_accelerations(System& system, State& state);

}  // namespace mimbre
