#pragma once
#include "mimbre/fe_mesh.h"

namespace mimbre::fe {

/// Displacements of the dofs (rows) in unit translations along x, y, z and unit rotations about them through
/// the origin (columns).
Eigen::MatrixXd rigid_shapes(const SolidMesh& mesh, const FeMatrices& matrices);

}  // namespace mimbre::fe
