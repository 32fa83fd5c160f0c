#pragma once
#include "dynamics/system.h"
#include "linalg/once/sparse_factor.h"

namespace mimbre {

/// A Jacobian of the constraints along the scales of the coordinates, its rows of length one.
struct SparseJacobian {
  linalg::SparseMatrix J;
  Eigen::VectorXd rows;  ///< what each row was multiplied by; 0: it vanishes
};

/// The Jacobian of the system's last matrix_values(). Allocates.
SparseJacobian sparse_jacobian(const System& system);

}  // namespace mimbre
