#include "fe/solve/lowest_modes.h"

#include <cmath>

#include "fe/solve/block_lanczos.h"

namespace mimbre::fe {

void fix_signs(Eigen::MatrixXd& columns) {
  if (columns.rows() == 0) return;
  for (Eigen::Index j = 0; j < columns.cols(); ++j) {
    const double limit = (1 - 1e-6) * columns.col(j).cwiseAbs().maxCoeff();
    Eigen::Index i = 0;
    while (i + 1 < columns.rows() && std::abs(columns(i, j)) < limit) ++i;
    if (columns(i, j) < 0) columns.col(j) *= -1;
  }
}

Modes lowest_modes(const Eigen::SparseMatrix<double>& M, int count, double shift,
                   const SymmetricSolver& factor) {
  using Eigen::MatrixXd;
  return block_lanczos({M.rows(), [&](const MatrixXd& b) -> MatrixXd { return factor.solve(b); },
                        [&](const MatrixXd& x) -> MatrixXd { return M * x; }, shift},
                       count);
}

}  // namespace mimbre::fe
