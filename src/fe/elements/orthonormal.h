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

/// What the span of orthonormal columns has of `field`. In loops: as an expression, a compiler takes a second
/// for each size.
template <int Rows, int Columns, int Fields>
Eigen::Matrix<double, Rows, Fields> projected(const Eigen::Matrix<double, Rows, Columns>& basis,
                                              const Eigen::Matrix<double, Rows, Fields>& field) {
  Eigen::Matrix<double, Rows, Fields> out = Eigen::Matrix<double, Rows, Fields>::Zero();
  for (int f = 0; f < Fields; ++f)
    for (int c = 0; c < Columns; ++c) {
      double share = 0;
      for (int r = 0; r < Rows; ++r) share += basis(r, c) * field(r, f);
      for (int r = 0; r < Rows; ++r) out(r, f) += share * basis(r, c);
    }
  return out;
}

}  // namespace mimbre::fe
