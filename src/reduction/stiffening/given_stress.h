#pragma once
#include "fe/surface.h"
#include "mimbre/fe_reduce.h"

/// Stress by a matrix of another program.
namespace mimbre::fe {

/// Throws std::invalid_argument unless sizes and nodes fit to the model and all entries are finite.
void require(const StressMatrix& stress, const SolidMesh& mesh, const FeMatrices& matrices);

/// The surface with the nodes of the stress as its points, in their order: of lines and triangles those that
/// lie between them.
Surface at_nodes(const StressMatrix& stress, const Surface& surface);

/// Rigid motions R (dofs × 6) stress nothing, unless the rows or columns are those of another model.
Check check_rigid(const StressMatrix& stress, const Eigen::MatrixXd& R);

}  // namespace mimbre::fe
