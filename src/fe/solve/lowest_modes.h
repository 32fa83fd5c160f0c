#pragma once
#include <Eigen/Core>
#include <Eigen/Sparse>

#include "fe/solve/symmetric_solver.h"

namespace mimbre::fe {

struct Modes {
  Eigen::VectorXd eigenvalues;  ///< ascending
  Eigen::MatrixXd vectors;      ///< columns, vᵀ M v = 1, the largest entry positive
};

/// The `count` lowest solutions of K v = λ M v, K positive semi-definite, M positive definite.
/// `factor` holds the factorisation of K − shift·M, shift ≤ 0 and below the lowest eigenvalue.
/// Throws std::runtime_error when the iteration does not converge.
Modes lowest_modes(const Eigen::SparseMatrix<double>& M, int count, double shift,
                   const SymmetricSolver& factor);

}  // namespace mimbre::fe
