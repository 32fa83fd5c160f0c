#pragma once
#include "integrate/stepper.h"

namespace mimbre {

struct StaticsStatus {
  bool converged = false;
  int iterations = 0;
  double residual = 0;   ///< largest generalised force that is not balanced, N or N m
  double violation = 0;  ///< max |Φ|
};

/// Static equilibrium at state.time: q and multipliers with Q − Φzᵀ λ = 0, Φ = 0 at rest, from state.q.
/// Pseudo-transient continuation (Kelley, Keyes 1998): Newton with the tangent by central differences and
/// M/τ² added, τ growing as the forces come to balance, so that neutral directions stay put and a mechanism
/// that does not touch yet falls until it does. On return velocities and accelerations are zero.
StaticsStatus find_equilibrium(System& system, State& state);

}  // namespace mimbre
