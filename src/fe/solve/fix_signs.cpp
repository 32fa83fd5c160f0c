#include "fe/solve/fix_signs.h"

#include <cmath>

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

}  // namespace mimbre::fe
