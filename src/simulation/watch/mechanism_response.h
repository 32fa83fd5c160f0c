#pragma once
#include <Eigen/Core>

#include "dynamics/relative/system.h"
#include "dynamics/state.h"

namespace mimbre {

/// Accelerations of a mechanism at rest in that state by forces on its velocity coordinates, which its
/// constraints permit: velocities × velocities, N (Nᵀ M N)⁻¹ Nᵀ with N the motions that they leave. Empty
/// where there are too many coordinates, or a motion without inertia.
Eigen::MatrixXd response_at(relative::RelativeSystem& system, const State& state);

}  // namespace mimbre
