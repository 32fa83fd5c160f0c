#pragma once
#include "integrate/stepper.h"

namespace mimbre {

struct StaticsStatus {
  bool converged = false;
  int iterations = 0;
  double residual = 0;  ///< generalised force that is not balanced and does most work, N or N m
  int coordinate = -1;  ///< where
  double position_violation = 0, angle_violation = 0;  ///< max |Φ| of lengths, m, and of angles, rad
  /// 1/s: how fast the smallest disturbance grows without damping, 0 where the equilibrium is stable or
  /// neutral: λ² of the least eigenvalue −λ² of the tangent stiffness along the motions that the constraints
  /// leave, by their mass.
  double growth = 0;
  int growing = -1;     ///< the coordinate that then moves most
  bool sparse = false;  ///< found by find_sparse_equilibrium()
  int load_steps = 0;   ///< equilibria sought on the way, unbalanced forces applied bit by bit; 0: at once
};

/// Static equilibrium at state.time: q and multipliers with Q − Φzᵀ λ = 0, Φ = 0 at rest, from state.q.
/// Pseudo-transient continuation (Kelley, Keyes 1998): Newton with the tangent by central differences and
/// M/τ² added, τ growing as the forces come to balance, so that neutral directions stay put and a mechanism
/// that does not touch yet falls until it does. Near an equilibrium one tangent serves for several steps.
/// Where that leads nowhere, once more from the start with τ that gets smaller where a step leads too far. On
/// return velocities and accelerations are zero. The system is left with the state's u and z entered, at
/// rest; z counts the turns on the way. Everything is measured by the mechanism's own scales (Scales):
/// similar mechanisms take the same iterations. `most_steps`: in each of the two attempts.
StaticsStatus find_equilibrium(System& system, State& state, int most_steps = 400);

}  // namespace mimbre
