#pragma once
#include <vector>

#include "mimbre/fe_reduce.h"

namespace mimbre::fe {

/// As check_matrices of the public header; the nodes of rigid interfaces, which move together, need no
/// stiffness of their own.
std::vector<Check> check_matrices(const SolidMesh& mesh, const FeMatrices& matrices,
                                  const std::vector<Interface>& interfaces);

/// How far inertia about the centre of mass is from that of the consistent masses. R: rigid_shapes.
Check lumped_check(const FeMatrices& consistent, const FeMatrices& lumped, const Eigen::MatrixXd& R);

}  // namespace mimbre::fe
