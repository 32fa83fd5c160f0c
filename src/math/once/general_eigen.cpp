#include "math/once/general_eigen.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

namespace mimbre {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// D, powers of two, so that rows and columns of D⁻¹ A D are of one size.
VectorXd balance(MatrixXd& A) {
  VectorXd d = VectorXd::Ones(A.rows());
  for (bool again = true; again;) {
    again = false;
    for (Index k = 0; k < A.rows(); ++k) {
      double row = A.row(k).cwiseAbs().sum() - std::abs(A(k, k)),
             column = A.col(k).cwiseAbs().sum() - std::abs(A(k, k));
      if (!(row > 0) || !(column > 0)) continue;
      const double before = row + column;
      int power = 0;
      while (column < row / 2 && power < 500) column *= 2, row /= 2, ++power;
      while (column > row * 2 && power > -500) column /= 2, row *= 2, --power;
      if (power == 0 || row + column > 0.95 * before) continue;
      A.row(k) = A.row(k) * std::ldexp(1.0, -power);
      A.col(k) = A.col(k) * std::ldexp(1.0, power);
      d[k] = std::ldexp(d[k], power);
      again = true;
    }
  }
  return d;
}

}  // namespace

ComplexPairs general_eigen(const MatrixXd& A) {
  if (A.size() == 0) return {Eigen::VectorXcd(0), Eigen::MatrixXcd(0, 0), true};
  if (!A.allFinite()) return {};
  MatrixXd balanced = A;
  const VectorXd d = balance(balanced);
  const Eigen::EigenSolver<MatrixXd> solver(balanced);
  if (solver.info() != Eigen::Success) return {};
  Eigen::MatrixXcd vectors = d.asDiagonal() * solver.eigenvectors();
  vectors.colwise().normalize();
  return {solver.eigenvalues(), vectors, true};
}

Eigen::MatrixXcd complex_inverse(const Eigen::MatrixXcd& A) { return A.partialPivLu().inverse(); }

}  // namespace mimbre
