#pragma once
#include <Eigen/Core>

#include "mimbre/reduced_body.h"

namespace mimbre {

/// The body with fewer modes, the columns of T (modes × fewer): amplitudes are restricted to y = T z, and all
/// that a body has of its modes is projected (Galerkin), without any loss within the columns' space. The
/// user's amplitudes are z, the modes are called "combination 1", …, the body has no eigenfrequencies until
/// make_orthogonal. Throws std::invalid_argument for other sizes, no columns, dependent ones, and bodies
/// whose amplitudes are not just linear (SecondOrder, AncfBeam).
ReducedBody project_modes(const ReducedBody& body, const Eigen::MatrixXd& T);

}  // namespace mimbre
