#pragma once
#include <Eigen/Core>

#include "mimbre/reduced_body.h"

namespace mimbre {

/// The same body, each of its modes with a small rigid motion added: `motion` (6 × modes) has the
/// displacement of the frame's origin and the turn, body axes, X' = X + t + θ × r. The same deformations,
/// seen from another frame. The inertia of the mesh is lost, and what its nodes' own rotary inertia has to do
/// with the turns. For bodies that are linear in their amplitudes.
ReducedBody with_moved_modes(const ReducedBody& body, const Eigen::MatrixXd& motion);

}  // namespace mimbre
