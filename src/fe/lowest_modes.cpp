#include "fe/lowest_modes.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

// Shift-invert block Krylov iteration with restarts: the space spanned by X, A X, A² X, … with A = (K − σM)⁻¹
// M and a block X wider than the number of modes wanted; Rayleigh–Ritz in it; restart with the best vectors.
// A block is needed because frames of round bars have double eigenvalues and free meshes a sixfold one: a
// single-vector Lanczos iteration sees one vector of each such eigenspace and finds the others by round-off
// or not at all.

namespace mimbre::fe {
namespace {

constexpr int kSpareVectors = 4;
constexpr int kBlocks = 4;
constexpr int kPatience = 20;
constexpr int kMaxRestarts = 200;

/// M x = ν (K − σM) x, ν = 1/(λ − σ): K − σM is positive definite, M may be nearly singular.
Modes dense_modes(const Eigen::SparseMatrix<double>& K, const Eigen::SparseMatrix<double>& M, int count,
                  double shift) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver{
      Eigen::MatrixXd(M), Eigen::MatrixXd(K) - shift * Eigen::MatrixXd(M)};
  if (solver.info() != Eigen::Success) throw std::runtime_error("dense eigensolver failed");
  const Eigen::VectorXd nu = solver.eigenvalues().tail(count).reverse();
  const Eigen::MatrixXd vectors = solver.eigenvectors().rightCols(count).rowwise().reverse();
  return {shift + nu.cwiseInverse().array(), vectors * nu.cwiseSqrt().cwiseInverse().asDiagonal()};
}

/// The same block on every platform (the standard distributions are not portable).
Eigen::MatrixXd start_block(Eigen::Index rows, Eigen::Index columns) {
  std::mt19937 generator(1);
  Eigen::MatrixXd block(rows, columns);
  for (double& entry : block.reshaped()) entry = generator() / 2147483648.0 - 1.0;
  return block;
}

/// Removes from `block` its part in the span of the M-orthonormal `basis`, then makes its columns
/// M-orthonormal. Columns that depend on the others are left out. Twice, because once loses orthogonality to
/// round-off.
Eigen::MatrixXd orthonormal_to(const Eigen::MatrixXd& basis, Eigen::MatrixXd block,
                               const Eigen::SparseMatrix<double>& M) {
  for (int pass = 0; pass < 2; ++pass) {
    if (basis.cols() > 0) block -= basis * (basis.transpose() * (M * block)).eval();
    const Eigen::MatrixXd gram = block.transpose() * (M * block);
    const Eigen::VectorXd scale = gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scale.asDiagonal() * gram *
                                                                scale.asDiagonal());
    const Eigen::VectorXd& values = solver.eigenvalues();
    const auto kept = (values.array() > 1e-14 * values.maxCoeff()).count();
    const Eigen::MatrixXd turn = scale.asDiagonal() * solver.eigenvectors().rightCols(kept) *
                                 values.tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
    block *= turn;
  }
  return block;
}

void append(Eigen::MatrixXd& basis, const Eigen::MatrixXd& block) {
  basis.conservativeResize(block.rows(), basis.cols() + block.cols());
  basis.rightCols(block.cols()) = block;
}

Modes block_krylov(const Eigen::SparseMatrix<double>& M, int count, double shift,
                   const SymmetricSolver& factor) {
  const Eigen::Index width = count + kSpareVectors;
  Eigen::MatrixXd block = start_block(M.rows(), width);
  Eigen::VectorXd previous = Eigen::VectorXd::Zero(count);
  for (int restart = 0; restart < kMaxRestarts; ++restart) {
    Eigen::MatrixXd basis(M.rows(), 0);
    Eigen::MatrixXd image(M.rows(), 0);
    for (int k = 0; k < kBlocks; ++k) {
      const Eigen::MatrixXd fresh =
          orthonormal_to(basis, k == 0 ? block : Eigen::MatrixXd(image.rightCols(width)), M);
      append(basis, fresh);
      append(image, factor.solve((M * fresh).eval()));
      if (fresh.cols() < width) break;
    }
    Eigen::MatrixXd projected = basis.transpose() * (M * image);
    projected = (0.5 * (projected + projected.transpose())).eval();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz(projected);  // ascending ν = 1/(λ − σ)
    const Eigen::Index best = std::min<Eigen::Index>(width, basis.cols());
    const Eigen::VectorXd nu = ritz.eigenvalues().tail(best).reverse();
    const Eigen::MatrixXd turn = ritz.eigenvectors().rightCols(best).rowwise().reverse();
    block = basis * turn;

    const Eigen::MatrixXd residual =
        image * turn.leftCols(count) - block.leftCols(count) * nu.head(count).asDiagonal();
    const Eigen::ArrayXd error =
        residual.cwiseProduct(M * residual).colwise().sum().transpose().array().max(0).sqrt() /
        nu.head(count).array();
    const double change = ((nu.head(count) - previous).array() / nu.head(count).array()).abs().maxCoeff();
    previous = nu.head(count);
    // The residual stalls at the round-off of the solve, which grows with the mesh's condition number.
    const bool stalled = error.maxCoeff() < 1e-6 && change < 1e-13;
    const bool good_enough = restart >= kPatience && error.maxCoeff() < 1e-4;
    if (error.maxCoeff() < 1e-11 || stalled || good_enough)
      return {shift + nu.head(count).cwiseInverse().array(), block.leftCols(count)};
  }
  throw std::runtime_error("the eigenvalue iteration of the finite-element model did not converge");
}

}  // namespace

void fix_signs(Eigen::MatrixXd& columns) {
  if (columns.rows() == 0) return;
  for (Eigen::Index j = 0; j < columns.cols(); ++j) {
    const double limit = (1 - 1e-6) * columns.col(j).cwiseAbs().maxCoeff();
    Eigen::Index i = 0;
    while (i + 1 < columns.rows() && std::abs(columns(i, j)) < limit) ++i;
    if (columns(i, j) < 0) columns.col(j) *= -1;
  }
}

Modes lowest_modes(const Eigen::SparseMatrix<double>& K, const Eigen::SparseMatrix<double>& M, int count,
                   double shift, const SymmetricSolver& factor) {
  if (count == 0) return {Eigen::VectorXd(0), Eigen::MatrixXd(K.rows(), 0)};
  const int krylov = kBlocks * (count + kSpareVectors);
  Modes modes =
      2 * krylov > K.rows() ? dense_modes(K, M, count, shift) : block_krylov(M, count, shift, factor);
  fix_signs(modes.vectors);
  return modes;
}

}  // namespace mimbre::fe
