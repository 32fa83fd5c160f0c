#include "math/once/general_eigen.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

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

/// Rows and columns in an order in which those with eigenvalues that the matrix shows lie outside: columns
/// that are zero but for the diagonal, among those not yet taken, then such rows. The iteration splits them
/// off without an error, and what is left is the better for it where zeros are multiple.
std::vector<Index> isolated_outside(const MatrixXd& A) {
  std::vector<Index> first, inside, last;
  for (Index k = 0; k < A.rows(); ++k) inside.push_back(k);
  const auto take = [&](std::vector<Index>& to, const auto& entry) {
    const auto is_alone = [&](Index k) {
      return std::all_of(inside.begin(), inside.end(), [&](Index i) { return i == k || entry(i, k) == 0; });
    };
    for (;;) {
      const auto alone = std::find_if(inside.begin(), inside.end(), is_alone);
      if (alone == inside.end()) return;
      to.push_back(*alone);
      inside.erase(alone);
    }
  };
  take(first, [&](Index i, Index k) { return A(i, k); });
  take(last, [&](Index i, Index k) { return A(k, i); });
  first.insert(first.end(), inside.begin(), inside.end());
  first.insert(first.end(), last.rbegin(), last.rend());
  return first;
}

}  // namespace

ComplexPairs general_eigen(const MatrixXd& A) {
  if (A.size() == 0) return {Eigen::VectorXcd(0), Eigen::MatrixXcd(0, 0), true};
  if (!A.allFinite()) return {};
  const std::vector<Index> order = isolated_outside(A);
  MatrixXd balanced = A(order, order);
  const VectorXd d = balance(balanced);
  const Eigen::EigenSolver<MatrixXd> solver(balanced);
  if (solver.info() != Eigen::Success) return {};
  Eigen::MatrixXcd vectors(A.rows(), A.cols());
  vectors(order, Eigen::all) = d.asDiagonal() * solver.eigenvectors();
  vectors.colwise().normalize();
  return {solver.eigenvalues(), vectors, true};
}

/// With [v, v̄] = [Re v, Im v] [1 1; i −i], of real matrices.
Eigen::MatrixXcd left_vectors(const ComplexPairs& pairs) {
  const Index n = pairs.values.size();
  // By the vectors: nearly real eigenvalues have real ones.
  const auto first_of_two = [&](Index k) { return k + 1 < n && !pairs.vectors.col(k).imag().isZero(0); };
  MatrixXd parts(n, n);
  for (Index k = 0; k < n; ++k) {
    parts.col(k) = pairs.vectors.col(k).real();
    if (first_of_two(k)) parts.col(k + 1) = pairs.vectors.col(k).imag(), ++k;
  }
  const MatrixXd inverse = parts.partialPivLu().inverse();
  Eigen::MatrixXcd out = inverse.cast<std::complex<double>>();
  for (Index k = 0; k < n; ++k) {
    if (!first_of_two(k)) continue;
    out.row(k).real() = inverse.row(k) / 2;
    out.row(k).imag() = -inverse.row(k + 1) / 2;
    out.row(k + 1) = out.row(k).conjugate();
    ++k;
  }
  return out;
}

Eigen::MatrixXcd complex_inverse(const Eigen::MatrixXcd& A) { return A.partialPivLu().inverse(); }

}  // namespace mimbre
