#pragma once
#include <Eigen/Core>

namespace mimbre::fe {

/// Orthonormal columns that span those of `a`; a column that depends on those before it becomes zero.
template <int Rows, int Columns>
Eigen::Matrix<double, Rows, Columns> orthonormal(Eigen::Matrix<double, Rows, Columns> a) {
  constexpr double dependent = 1e-6;
  for (int c = 0; c < Columns; ++c) {
    const double length = a.col(c).norm();
    for (int pass = 0; pass < 2; ++pass)  // twice, against round-off
      for (int k = 0; k < c; ++k) a.col(c) -= a.col(k).dot(a.col(c)) * a.col(k);
    const double left = a.col(c).norm();
    if (left > dependent * length)
      a.col(c) /= left;
    else
      a.col(c).setZero();
  }
  return a;
}

}  // namespace mimbre::fe
