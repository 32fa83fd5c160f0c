#pragma once
#include "integrate/statics.h"
#include "linalg/colouring.h"

namespace mimbre {

/// As find_equilibrium(), for mechanisms of any size and for starts far away. `colours`: which unknowns of
/// the system couple with each other through forces and equations.
///
/// Each iteration solves (K + M/τ²) x + Φzᵀ δλ = −r, Φz x = −Φ with sparse matrices. K contains the stiffness
/// of constraint forces and comes from differences by colours. τ is that of a trust region: it decreases
/// until the matrix is positive definite along the motions that the constraints leave, and where a step would
/// lead beyond a minimum along it, which the work r·x at its end shows; it increases where the linear
/// equations predict that work. Accepted positions fulfil the equations.
///
/// Where that finds nothing, the forces that are not balanced at the start are applied in steps
/// (StaticsStatus::load_steps). `growing` (optional): the motion of the disturbance that grows, velocities
/// × 1.
StaticsStatus find_sparse_equilibrium(System& system, const linalg::ColumnColours& colours, State& state,
                                      Eigen::VectorXd* growing = nullptr);

/// The multipliers of find_multipliers() with sparse matrices, for systems with many equations.
void find_sparse_multipliers(System& system, State& state);

}  // namespace mimbre
