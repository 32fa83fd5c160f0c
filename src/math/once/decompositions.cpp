#include "math/once/decompositions.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>

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

Eigen::Vector3d eigenvalues3(const Eigen::Matrix3d& A) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

Eigen::Vector4d eigenvalues4(const Eigen::Matrix4d& A) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

Eigen::Matrix<double, 6, 1> eigenvalues6(const Eigen::Matrix<double, 6, 6>& A) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>>(A, Eigen::EigenvaluesOnly).eigenvalues();
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
