#include "math/once/decompositions.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

namespace mimbre {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Eigen sums long products in blocks that fit the processor's first cache. One size for all processors, so
/// that these sums are the same on every machine.
[[maybe_unused]] const bool blocks_are_the_same = [] {
  Eigen::setCpuCacheSizes(32 * 1024, 256 * 1024, 2 * 1024 * 1024);
  return true;
}();

using Symmetric = Eigen::SelfAdjointEigenSolver<MatrixXd>;
using Generalized = Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd>;

Eigen::CompleteOrthogonalDecomposition<MatrixXd> orthogonal(const MatrixXd& A, double threshold) {
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> cod(A.rows(), A.cols());
  if (threshold > 0) cod.setThreshold(threshold);
  cod.compute(A);
  return cod;
}

Eigen::ColPivHouseholderQR<MatrixXd> pivoted_qr(const MatrixXd& A, double threshold) {
  Eigen::ColPivHouseholderQR<MatrixXd> qr(A.rows(), A.cols());
  if (threshold > 0) qr.setThreshold(threshold);
  qr.compute(A);
  return qr;
}

/// Beyond this many sweeps of the matrix nothing converges any more.
constexpr int most_sweeps = 50;
constexpr double round_off = std::numeric_limits<double>::epsilon() / 4;  ///< of a row's absolute sum

/// Turns rows and columns p and q of the symmetric n × n matrix a so that a_pq becomes 0 (Golub and Van Loan
/// 2013, algorithm 8.5.1). False where it is no larger than `least`.
bool turn_away(double* a, int n, int p, int q, double least) {
  const double apq = a[p * n + q], app = a[p * n + p], aqq = a[q * n + q];
  if (std::abs(apq) <= least) return false;
  const double half = (aqq - app) / (2 * apq);
  const double t = (half < 0 ? -1 : 1) / (std::abs(half) + std::sqrt(1 + half * half));
  const double c = 1 / std::sqrt(1 + t * t), s = t * c;
  for (int k = 0; k < n; ++k) {
    const double x = a[k * n + p], y = a[k * n + q];
    a[k * n + p] = c * x - s * y;
    a[k * n + q] = s * x + c * y;
  }
  for (int k = 0; k < n; ++k) {
    const double x = a[p * n + k], y = a[q * n + k];
    a[p * n + k] = c * x - s * y;
    a[q * n + k] = s * x + c * y;
  }
  a[p * n + q] = a[q * n + p] = 0;
  return true;
}

/// By Jacobi's cyclic method, ascending: Eigen's solver of fixed size took half of this file's time to
/// compile.
template <int n>
Eigen::Matrix<double, n, 1> small_eigenvalues(const Eigen::Matrix<double, n, n>& A) {
  double a[n * n], values[n];
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < n; ++k) a[i * n + k] = i < k ? A(k, i) : A(i, k);
  double size = 0;
  for (const double x : a) size += std::abs(x);
  if (!std::isfinite(size))
    return Eigen::Matrix<double, n, 1>::Constant(std::numeric_limits<double>::quiet_NaN());
  bool turns = true;
  for (int sweep = 0; turns && sweep < most_sweeps; ++sweep) {
    turns = false;
    for (int p = 0; p < n; ++p)
      for (int q = p + 1; q < n; ++q)
        if (turn_away(a, n, p, q, round_off / n * size)) turns = true;
  }
  for (int k = 0; k < n; ++k) values[k] = a[k * n + k];
  std::sort(values, values + n);
  return Eigen::Map<const Eigen::Matrix<double, n, 1>>(values);
}

}  // namespace

EigenPairs symmetric_eigen(const MatrixXd& A) {
  if (A.size() == 0) return {VectorXd(0), MatrixXd(0, 0), true};
  const Symmetric solver(A);
  return {solver.eigenvalues(), solver.eigenvectors(), solver.info() == Eigen::Success};
}

EigenPairs symmetric_eigen(const MatrixXd& K, const MatrixXd& M) {
  if (K.size() == 0) return {VectorXd(0), MatrixXd(0, 0), true};
  const Generalized solver(K, M);
  return {solver.eigenvalues(), solver.eigenvectors(), solver.info() == Eigen::Success};
}

VectorXd symmetric_eigenvalues(const MatrixXd& A) {
  if (A.size() == 0) return {};
  return Symmetric(A, Eigen::EigenvaluesOnly).eigenvalues();
}

VectorXd symmetric_eigenvalues(const MatrixXd& K, const MatrixXd& M) {
  if (K.size() == 0) return {};
  return Generalized(K, M, Eigen::EigenvaluesOnly).eigenvalues();
}

Eigen::VectorXcd eigenvalues(const MatrixXd& A) {
  const Eigen::EigenSolver<MatrixXd> solver(A, false);
  if (solver.info() != Eigen::Success) return {};
  return solver.eigenvalues();
}

Eigen::Vector3d eigenvalues3(const Eigen::Matrix3d& A) { return small_eigenvalues(A); }
Eigen::Vector4d eigenvalues4(const Eigen::Matrix4d& A) { return small_eigenvalues(A); }
Eigen::Matrix<double, 6, 1> eigenvalues6(const Eigen::Matrix<double, 6, 6>& A) {
  return small_eigenvalues(A);
}

Cholesky::Cholesky(const MatrixXd& A) : factor_(A), ok_(factor_.info() == Eigen::Success) {}
MatrixXd Cholesky::lower() const { return factor_.matrixL(); }
MatrixXd Cholesky::solve(const MatrixXd& b) const { return factor_.solve(b); }
MatrixXd Cholesky::solve_lower(const MatrixXd& b) const { return factor_.matrixL().solve(b); }
MatrixXd Cholesky::solve_upper(const MatrixXd& b) const { return factor_.matrixU().solve(b); }
bool is_positive_definite(const MatrixXd& A) { return Cholesky(A).ok(); }

PivotedCholesky::PivotedCholesky(const MatrixXd& A) : factor_(A) {}
void PivotedCholesky::compute(const MatrixXd& A) { factor_.compute(A); }
MatrixXd PivotedCholesky::solve(const MatrixXd& b) const { return factor_.solve(b); }
void PivotedCholesky::solve_in_place(VectorXd& b) const { factor_.solveInPlace(b); }
double PivotedCholesky::least_pivot() const { return factor_.vectorD().minCoeff(); }
int PivotedCholesky::singular_at(const MatrixXd& A, double least, VectorXd& work) const {
  work.setLinSpaced(A.rows(), 0, static_cast<double>(A.rows()) - 1);
  work = factor_.transpositionsP() * work;
  for (Index k = 0; k < A.rows(); ++k) {
    const auto place = static_cast<Index>(work[k]);
    if (!(std::abs(factor_.vectorD()[k]) > least * std::abs(A(place, place)))) return static_cast<int>(place);
  }
  return -1;
}

MatrixXd solve(const MatrixXd& A, const MatrixXd& b) { return A.partialPivLu().solve(b); }
MatrixXd inverse(const MatrixXd& A) { return A.partialPivLu().inverse(); }
std::optional<MatrixXd> inverse_if_regular(const MatrixXd& A) {
  const Eigen::FullPivLU<MatrixXd> factor(A);
  if (!factor.isInvertible()) return {};
  return MatrixXd(factor.inverse());
}

MatrixXd least_squares(const MatrixXd& A, const MatrixXd& b) { return A.householderQr().solve(b); }
MatrixXd shortest_solution(const MatrixXd& A, const MatrixXd& b, double threshold) {
  return orthogonal(A, threshold).solve(b);
}
MatrixXd pseudo_inverse(const MatrixXd& A, double threshold) {
  return orthogonal(A, threshold).pseudoInverse();
}

ColumnOrder order_columns(const MatrixXd& A, double threshold) {
  if (A.size() == 0) return {};
  const auto qr = pivoted_qr(A, threshold);
  const auto& order = qr.colsPermutation().indices();
  return {{order.begin(), order.end()}, static_cast<int>(qr.rank()), std::abs(qr.maxPivot())};
}

MatrixXd null_space(const MatrixXd& A, double threshold) {
  const auto qr = pivoted_qr(A.transpose(), threshold);
  return MatrixXd(qr.householderQ()).rightCols(A.cols() - qr.rank());
}

}  // namespace mimbre
