#include "fe/solve/lowest_modes.h"

#include "fe/solve/block_lanczos.h"

namespace mimbre::fe {

Modes lowest_modes(const Eigen::SparseMatrix<double>& M, int count, double shift,
                   const SymmetricSolver& factor) {
  using Eigen::MatrixXd;
  return block_lanczos({M.rows(), [&](const MatrixXd& b) -> MatrixXd { return factor.solve(b); },
                        [&](const MatrixXd& x) -> MatrixXd { return M * x; }, shift},
                       count);
}

}  // namespace mimbre::fe
