#include "fe/solve/block_lanczos.h"
#include "fe/solve/fix_signs.h"
#include "math/once/decompositions.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Wide enough for the multiplicities that symmetric parts have.
constexpr Index kWidth = 6;
constexpr Index kMostBelow = 1000;
constexpr double kTolerance = 1e-9;  // of a vector's residual; its eigenvalue is then right to the square

/// The same block on every platform.
MatrixXd start_block(Index rows, Index columns) {
  std::mt19937 generator(1);
  MatrixXd block(rows, columns);
  for (double& entry : block.reshaped()) entry = generator() / 2147483648.0 - 1.0;
  return block;
}

constexpr double kNotOrthogonal = 1e-4;  // far above round-off
constexpr double kNegative = 1e-6;       // of |v| |M v|; vᵀ M v of less than its negative is not round-off

/// 1/√(vᵀ M v) of each column; 0 where a column has no mass.
VectorXd inverse_lengths(const MatrixXd& block, const MatrixXd& image, const VectorXd& squares) {
  const VectorXd sizes = block.colwise().norm().cwiseProduct(image.colwise().norm()).transpose();
  if ((squares.array() < -kNegative * sizes.array()).any())
    throw std::invalid_argument(
        "the mass matrix of the finite-element model is not positive: some motion has a "
        "negative kinetic energy");
  return (squares.array() > 1e-300).select(squares.cwiseMax(1e-300).cwiseSqrt().cwiseInverse(), 0.0);
}

/// block = out · triangle with out M-orthonormal; columns that depend on the others, or have no mass, are
/// dropped.
struct Orthonormal {
  MatrixXd block, factor;
};
Orthonormal orthonormal_block(const Pencil& pencil, const MatrixXd& block) {
  MatrixXd out = block, factor = MatrixXd::Identity(block.cols(), block.cols());
  for (int pass = 0; pass < 2 && out.cols() > 0; ++pass) {
    const MatrixXd image = pencil.mass(out), gram = out.transpose() * image;
    if (!out.allFinite() || !gram.allFinite())
      throw std::invalid_argument(
          "the finite-element model is singular, or its masses and stiffnesses are beyond what "
          "double precision can hold: check units, density and elastic moduli");
    const VectorXd inverse = inverse_lengths(out, image, gram.diagonal());
    const MatrixXd scaled = inverse.asDiagonal() * gram * inverse.asDiagonal();
    const EigenPairs pairs = symmetric_eigen(0.5 * (scaled + scaled.transpose()));
    const VectorXd& values = pairs.values;
    const Index kept = (values.array() > 1e-13 * std::max(values.maxCoeff(), 0.0)).count();
    const MatrixXd vectors = pairs.vectors.rightCols(kept);
    const VectorXd roots = values.tail(kept).cwiseSqrt();
    const VectorXd lengths = (inverse.array() > 0).select(inverse.cwiseInverse(), 0.0);
    factor = roots.asDiagonal() * vectors.transpose() * lengths.asDiagonal() * factor;
    out = out * (inverse.asDiagonal() * vectors * roots.cwiseInverse().asDiagonal());
  }
  return {out, factor};
}

/// Called with the estimates of λ found so far, ascending: how many of the lowest must have converged.
using Wanted = std::function<Index(const VectorXd&)>;

/// `fewest`: so many modes are wanted at least.
Modes iterate(const Pencil& pencil, const Wanted& wanted, Index fewest,
              const std::function<void(double)>& progress) {
  const Index rows = pencil.rows > 0 ? pencil.rows : pencil.size;
  const Index width = std::min<Index>(kWidth, pencil.size);
  MatrixXd basis(rows, 0), projected(0, 0);
  Orthonormal next = orthonormal_block(pencil, pencil.solve(pencil.mass(start_block(rows, width))));
  if (next.block.cols() == 0)
    throw std::invalid_argument(
        "no part of the finite-element model that can move has a mass that counts beside its "
        "stiffness: check units, density and elastic moduli");
  Index columns = 0, next_look = fewest;
  while (true) {
    const Index fresh = std::min(next.block.cols(), pencil.size - columns);
    if (columns + fresh > basis.cols()) {
      const Index room = std::min(pencil.size, 2 * basis.cols() + 66);
      basis.conservativeResize(rows, room);
      projected.conservativeResize(room, room);
    }
    basis.middleCols(columns, fresh) = next.block.leftCols(fresh);
    MatrixXd image = pencil.solve(pencil.mass(next.block.leftCols(fresh)));
    const Index first = columns;
    columns += fresh;
    const auto known = basis.leftCols(columns);
    MatrixXd products = MatrixXd::Zero(columns, fresh);
    for (int pass = 0; pass < 2; ++pass) {  // once loses orthogonality to round-off
      const MatrixXd h = known.transpose() * pencil.mass(image);
      image -= known * h;
      products += h;
    }
    projected.block(0, first, columns, fresh) = products;
    projected.block(first, 0, fresh, columns) = products.transpose();
    next = orthonormal_block(pencil, image);

    // The small eigenproblem costs columns³: it waits until enough columns are there, and then for a
    // sixteenth more.
    const bool complete = columns >= pencil.size || next.block.cols() == 0;
    if (!complete && columns < next_look) continue;
    next_look = columns + columns / 16;
    const MatrixXd T = projected.topLeftCorner(columns, columns);
    const EigenPairs ritz = symmetric_eigen(0.5 * (T + T.transpose()));  // ascending 1/(λ − σ)
    const VectorXd all = ritz.values.reverse();
    const VectorXd estimates = pencil.shift + all.cwiseInverse().array();
    const Index count = wanted(estimates), found = std::min(count, columns);
    const MatrixXd turn = ritz.vectors.rightCols(found).rowwise().reverse();
    const VectorXd residuals = (next.factor * turn.bottomRows(fresh)).colwise().norm();
    const Index converged = (residuals.array() <= kTolerance * all.head(found).array()).count();
    if (progress) progress(static_cast<double>(converged) / static_cast<double>(count));
    if (converged == count || complete) {
      Modes modes{estimates.head(found), basis.leftCols(columns) * turn};
      fix_signs(modes.vectors);
      return modes;
    }
    if (columns >= 6 * count + 60)
      throw std::runtime_error("the eigenvalue iteration of the finite-element model did not converge");
  }
}

}  // namespace

Modes block_lanczos(const Pencil& pencil, int count, const std::function<void(double)>& progress) {
  if (count == 0) return {VectorXd(0), MatrixXd(pencil.rows > 0 ? pencil.rows : pencil.size, 0)};
  if (count > pencil.size)
    throw std::invalid_argument(fmt::format("more modes asked, {}, than there are unknowns that can move, {}",
                                            count, static_cast<std::ptrdiff_t>(pencil.size)));
  Modes modes = iterate(
      pencil, [count](const VectorXd&) { return Index{count}; }, count, progress);
  // Of a mass of low rank the iteration ends early, or goes on with round-off and finds modes twice.
  const MatrixXd gram = modes.vectors.transpose() * pencil.mass(modes.vectors);
  if (gram.cols() < count || !gram.isIdentity(kNotOrthogonal))
    throw std::invalid_argument(
        "the finite-element model has fewer modes of finite frequency than asked for: too few of its nodes "
        "have mass");
  return modes;
}

Modes block_lanczos_below(const Pencil& pencil, double limit, const std::function<void(double)>& progress) {
  const auto below = [limit](const VectorXd& eigenvalues) { return (eigenvalues.array() <= limit).count(); };
  // One more: when it has converged nothing is left below it.
  const auto wanted = [&](const VectorXd& estimates) {
    const Index count = below(estimates);
    if (count > kMostBelow)
      throw std::invalid_argument("more than 1000 modes lie below the frequency; is it in hertz?");
    return count + 1;
  };
  Modes modes = iterate(pencil, wanted, 1, progress);
  const Index count = below(modes.eigenvalues);
  modes.eigenvalues.conservativeResize(count);
  modes.vectors.conservativeResize(Eigen::NoChange, count);
  return modes;
}

}  // namespace mimbre::fe
