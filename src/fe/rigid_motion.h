#pragma once
#include <Eigen/Core>
#include <Eigen/Sparse>

#include "mimbre/fe.h"

namespace mimbre::fe {

struct RigidMotions {
  int count = 0;  ///< independent rigid motions that the fixed directions leave to the mesh
  int node = -1;  ///< a node of the first part of the mesh that can move so, −1 when there is none
};

/// Rigid-body motions left free, over all connected parts of the mesh. The stiffness is singular by exactly
/// these: counting them is sharp where a pivot threshold would have to guess. Columns of `fixed` (6·nodes
/// rows) are the directions held, each on one node.
RigidMotions free_rigid_motions(const Mesh& mesh, const Eigen::SparseMatrix<double>& fixed);

}  // namespace mimbre::fe
