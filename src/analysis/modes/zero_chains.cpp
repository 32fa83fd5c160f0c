#include "analysis/modes/zero_chains.h"

#include <algorithm>
#include <cmath>

#include "math/once/decompositions.h"

namespace mimbre::linear {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Of entries of size 1: ranks.
constexpr double nothing = 1e-9;
/// Of the largest entry of a row: entries that are less have cancelled and are judged as if they were this.
constexpr double cancelled = 1e-4;
constexpr int equilibrations = 20;

/// λ E x = F x, and how large the entries of F were before they cancelled.
struct Pencil {
  MatrixXd E, F, sizes;
};

/// What each row is at least, of the columns from `first` on, as these are along `scale`.
void set_least(MatrixXd& sizes, Index row, Index first, const VectorXd& scale, double other) {
  auto part = sizes.row(row).segment(first, scale.size());
  if (scale.size() == 0) return;
  const double largest = std::max(part.cwiseProduct(scale.transpose()).maxCoeff(), other);
  part = part.cwiseMax(cancelled * largest * scale.cwiseInverse().transpose());
}

Pencil pencil_of(const Reduced& r, const VectorXd& positions, const VectorXd& velocities,
                 double acceleration) {
  const Index y = r.coordinates, f = r.speeds;
  Pencil p;
  p.E = MatrixXd::Identity(r.A.rows(), r.A.cols());
  p.E.block(y, y, f, f) = r.mass;
  p.F = r.A;
  p.F.middleRows(y, f) = r.mass * r.A.middleRows(y, f);
  p.sizes = p.F.cwiseAbs();
  for (Index k = 0; k < p.F.rows(); ++k) {
    // Weights leave round-off where they cancel.
    const Index s = k - y;
    const double inertia = s >= 0 && s < f ? std::abs(r.mass(s, s)) * velocities[s] : 0;
    set_least(p.sizes, k, 0, positions, inertia * acceleration);
    set_least(p.sizes, k, y, velocities, inertia * std::sqrt(acceleration));
  }
  return p;
}

/// Makes the largest size of each row and column 1 (Ruiz). Returns the factors of the columns.
VectorXd equilibrate(Pencil& p) {
  VectorXd all = VectorXd::Ones(p.F.cols());
  const auto factor = [](const VectorXd& largest) {
    return VectorXd(largest.unaryExpr([](double x) { return x > 0 ? 1 / std::sqrt(x) : 1; }));
  };
  for (int k = 0; k < equilibrations; ++k) {
    const VectorXd rows = factor(p.sizes.rowwise().maxCoeff()),
                   columns = factor(p.sizes.colwise().maxCoeff().transpose());
    for (MatrixXd* x : {&p.E, &p.F, &p.sizes}) *x = (rows.asDiagonal() * *x * columns.asDiagonal()).eval();
    all = all.cwiseProduct(columns);
  }
  return all;
}

/// Columns at right angles to those of X, which are independent.
MatrixXd complement(MatrixXd X) {
  X.colwise().normalize();
  return null_space(X.transpose(), 1e-14).rightCols(X.rows() - X.cols());
}

}  // namespace

Zeros zero_chains(const Reduced& r, const VectorXd& positions, const VectorXd& velocities,
                  double acceleration) {
  Zeros out;
  out.vectors.resize(r.A.rows(), 0);
  Pencil p = pencil_of(r, positions, velocities, acceleration);
  while (p.F.rows() > 0) {
    const VectorXd columns = equilibrate(p);
    const bool any = p.F.cwiseAbs().maxCoeff() > nothing;
    const MatrixXd free = any ? null_space(p.F, nothing) : MatrixXd::Identity(p.F.rows(), p.F.rows());
    if (free.cols() == 0) break;
    if (out.count == 0) out.vectors = columns.asDiagonal() * free;
    out.count += static_cast<int>(free.cols());
    if (free.cols() == p.F.rows()) break;
    const MatrixXd left = complement(p.E * free), right = complement(free);
    p.E = (left.transpose() * p.E * right).eval();
    p.F = (left.transpose() * p.F * right).eval();
    p.sizes = (left.cwiseAbs().transpose() * p.sizes * right.cwiseAbs()).eval();
  }
  return out;
}

}  // namespace mimbre::linear
