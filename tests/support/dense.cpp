#include "support/dense.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "math/once/decompositions.h"

namespace mimbre::test {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;

MatrixXd full(const Eigen::SparseMatrix<double>& lower) {
  return MatrixXd(Eigen::SparseMatrix<double>(lower.selfadjointView<Eigen::Lower>()));
}

MatrixXd congruent(const MatrixXd& A, const MatrixXd& T) { return T.transpose() * A * T; }

double relative_difference(const MatrixXd& a, const MatrixXd& b, double floor) {
  if (a.size() == 0 && b.size() == 0) return 0;
  const double scale = std::max({floor, a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff()});
  const double difference = (a - b).cwiseAbs().maxCoeff();
  return std::isfinite(difference) ? difference / scale : HUGE_VAL;
}

MatrixXcd solve(const MatrixXcd& A, const MatrixXd& b) {
  // [Re −Im; Im Re] [x; y] = [b; 0]
  const Eigen::Index n = A.rows();
  MatrixXd real(2 * n, 2 * n), right = MatrixXd::Zero(2 * n, b.cols());
  real << A.real(), -A.imag(), A.imag(), A.real();
  right.topRows(n) = b;
  const MatrixXd parts = mimbre::solve(real, right);
  MatrixXcd x(n, b.cols());
  x.real() = parts.topRows(n);
  x.imag() = parts.bottomRows(n);
  return x;
}

Eigen::VectorXcd eigenvalues(const MatrixXd& A) { return A.eigenvalues(); }

}  // namespace mimbre::test
