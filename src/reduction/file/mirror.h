#pragma once
#include "mimbre/reduced_body.h"

namespace mimbre {

/// The mirror image of a body by M = diag(signs), signs ±1, in body axes: its points are M p, the axes of its
/// frames M R M, and at amplitudes y it is the mirror image of the body at y. With an even number of −1 it is
/// the body turned by half a turn. Names, labels and the validation report stay.
ReducedBody mirrored(const ReducedBody& body, const Eigen::Vector3d& signs);

}  // namespace mimbre
