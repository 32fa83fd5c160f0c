#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "integrate/stepper.h"

namespace mimbre {

/// Φz of the system at (t, q), dense: equations × velocities.
Eigen::MatrixXd dense_jacobian(System& system, double t, const Eigen::VectorXd& q);

/// Moves q onto the constraints with the least change of the coordinates, Σ (x / weight)². `weight`
/// (velocities × 1, ≥ 0), in the units of the coordinates, determines how readily each one moves, 0: not at
/// all. Returns the violation that is left, max |Φ| by the scales of the equations. Equations that are
/// redundant on the constraints seem to be independent off them, by a little, and what they ask for there may
/// move the mechanism far; `caution` > 0 (30 for gaps that are small) keeps it near. Where no coordinate that
/// moves by its weight moves any equation, by its scale, by more than `negligible` they hold nothing.
/// Positions are free along equations of velocities alone. `arrived` is called at every position on the way.
double close_positions(System& system, double t, const Eigen::VectorXd& weight, Eigen::VectorXd& q,
                       double caution = 0, double negligible = 1e-13,
                       const std::function<void()>& arrived = {});

/// The same for velocities: Φz v = −Φt. Returns max |Φ̇| by the scales of the equations, 1/s.
double close_velocities(System& system, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& weight,
                        Eigen::VectorXd& v);

/// Multipliers that balance the forces at the given motion best, of those the smallest: M a + Φzᵀ λ = Q in
/// the sense of least squares, by the work along the scales of the coordinates.
void find_multipliers(System& system, State& state, double negligible = 1e-13);

/// Accelerations and multipliers of the equations of motion at state.time, q, v: M a + Φzᵀ λ = Q, Φ̈ = 0.
/// Where some motion has no inertia beyond round-off, but springs and dampers hold it, the accelerations are
/// those that a step of length `step` can bring about, with M + γh C + βh² K instead of M. False where that
/// does not determine them either, or forces are not finite; `undetermined`: the coordinate, -1: unknown.
bool solve_accelerations(System& system, State& state, double step = 0, int* undetermined = nullptr);

}  // namespace mimbre
