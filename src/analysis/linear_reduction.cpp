#include "analysis/linear_reduction.h"

#include <algorithm>
#include <cmath>

#include "math/once/decompositions.h"

namespace mimbre::linear {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Equations that add less than this to others, as a share of the largest, are redundant.
constexpr double repeated = 1e-9;
/// Of the largest inertia along the scales: a motion with less has none.
constexpr double no_inertia = 1e-13;
/// Of an entry of a mass that is not symmetric, over the roots of the diagonal.
constexpr double one_way = 1e-8;

VectorXd scales_of(const std::vector<double>& scale) {
  return Eigen::Map<const VectorXd>(scale.data(), std::ssize(scale));
}

/// A X, in which columns of zeros cost nothing.
MatrixXd product(const MatrixXd& A, const MatrixXd& X) {
  std::vector<Eigen::Index> filled;
  for (Eigen::Index k = 0; k < X.cols(); ++k)
    if (!X.col(k).isZero(0)) filled.push_back(k);
  if (std::ssize(filled) == X.cols()) return A * X;
  MatrixXd out = MatrixXd::Zero(A.rows(), X.cols());
  if (!filled.empty()) out(Eigen::all, filled) = A * MatrixXd(X(Eigen::all, filled));
  return out;
}

/// The coordinate with no inertia, by the scales; -1: all have some.
int massless_coordinate(const MatrixXd& mass, const VectorXd& scale) {
  if (mass.rows() == 0) return -1;
  const MatrixXd scaled = scale.asDiagonal() * mass * scale.asDiagonal();
  const VectorXd diagonal = scaled.diagonal();
  const double largest = diagonal.cwiseAbs().maxCoeff();
  Eigen::Index least = 0;
  if (!(diagonal.minCoeff(&least) > no_inertia * largest)) return static_cast<int>(least);
  // Of unit diagonal, so that light parts count as much as heavy ones.
  const VectorXd inverse = diagonal.cwiseSqrt().cwiseInverse();
  const MatrixXd unit = inverse.asDiagonal() * (scaled + scaled.transpose()) / 2 * inverse.asDiagonal();
  // Nearly always, and much faster than the eigenvalues.
  if (is_positive_definite(unit - 2 * no_inertia * MatrixXd::Identity(unit.rows(), unit.cols()))) return -1;
  // Loads of inertia that stiffen a body act one way only: of such a mass the symmetric part says nothing.
  if (const MatrixXd given = inverse.asDiagonal() * scaled * inverse.asDiagonal();
      (given - given.transpose()).cwiseAbs().maxCoeff() > one_way) {
    const Eigen::VectorXcd values = eigenvalues(given);
    if (values.size() > 0 && values.real().minCoeff() > no_inertia) return -1;
  }
  const EigenPairs pairs = symmetric_eigen(unit);
  if (!pairs.ok || pairs.values[0] > no_inertia) return -1;
  pairs.vectors.col(0).cwiseAbs().maxCoeff(&least);
  return static_cast<int>(least);
}

}  // namespace

Independent::Independent(const MatrixXd& jacobian, const Scales& scales, bool positions,
                         const std::vector<int>& chosen)
    : rows_(scales_of(scales.equations).cwiseInverse()), columns_(scales_of(scales.coordinates)) {
  if (positions)
    for (std::size_t k = 0; k < scales.is_rate.size(); ++k)
      if (scales.is_rate[k]) rows_[static_cast<Eigen::Index>(k)] = 0;
  const auto n = static_cast<int>(jacobian.cols());
  scaled_ = rows_.asDiagonal() * jacobian * columns_.asDiagonal();
  std::vector<char> is_dependent(static_cast<std::size_t>(n), 0);
  if (!chosen.empty()) {
    is_dependent.assign(static_cast<std::size_t>(n), 1);
    for (const int k : chosen) is_dependent[static_cast<std::size_t>(k)] = 0;
  } else if (scaled_.size() > 0 && scaled_.cwiseAbs().maxCoeff() > 1e-13) {
    const ColumnOrder order = order_columns(scaled_, repeated);
    for (int k = 0; k < order.rank; ++k)
      is_dependent[static_cast<std::size_t>(order.order[static_cast<std::size_t>(k)])] = 1;
  }
  for (int k = 0; k < n; ++k)
    (is_dependent[static_cast<std::size_t>(k)] ? dependent_ : independent_).push_back(k);
  const auto f = static_cast<Eigen::Index>(independent_.size());
  motions_ = MatrixXd::Zero(n, f);
  if (rank() > 0) motions_ = particular(-jacobian(Eigen::all, independent_));
  for (Eigen::Index k = 0; k < f; ++k) motions_(independent_[static_cast<std::size_t>(k)], k) = 1;
}

MatrixXd Independent::particular(const MatrixXd& b) const {
  MatrixXd x = MatrixXd::Zero(scaled_.cols(), b.cols());
  if (rank() == 0 || b.cols() == 0) return x;
  const MatrixXd found = least_squares(scaled_(Eigen::all, dependent_), rows_.asDiagonal() * b);
  for (int k = 0; k < rank(); ++k) {
    const int at = dependent_[static_cast<std::size_t>(k)];
    x.row(at) = columns_[at] * found.row(k);
  }
  return x;
}

MatrixXd Independent::multipliers(const MatrixXd& b) const {
  if (scaled_.rows() == 0) return MatrixXd::Zero(0, b.cols());
  if (rank() == 0) return MatrixXd::Zero(scaled_.rows(), b.cols());
  return rows_.asDiagonal() * shortest_solution(scaled_.transpose(), columns_.asDiagonal() * b, repeated);
}
VectorXd Independent::multipliers(const VectorXd& b) const { return multipliers(MatrixXd(b)).col(0); }

MatrixXd Independent::redundant() const {
  const auto m = scaled_.rows();
  if (rank() == m) return MatrixXd(m, 0);
  if (rank() == 0) return MatrixXd::Identity(m, m);
  return rows_.asDiagonal() * null_space(scaled_(Eigen::all, dependent_).transpose(), repeated);
}

bool consistent_accelerations(const Derivatives& d, const Independent& independent, const Scales& scales,
                              VectorXd& a, VectorXd& multipliers, int& massless) {
  const MatrixXd& N = independent.motions();
  const VectorXd particular = independent.particular(-d.phi_second).col(0);
  const MatrixXd mass = N.transpose() * d.mass * N;
  massless = massless_coordinate(mass, scales_of(scales.coordinates)(independent.coordinates()));
  if (massless >= 0) {
    massless = independent.coordinates()[static_cast<std::size_t>(massless)];
    return false;
  }
  a = particular;
  if (N.cols() > 0) a += N * solve(mass, -N.transpose() * (d.residual + d.mass * particular));
  multipliers = independent.multipliers(VectorXd(-d.residual - d.mass * a));
  return true;
}

Reduced reduce(const Derivatives& d, const LinearCore::Rates& rates, const Independent& positions,
               const Independent& independent, const Scales& scales, int& massless) {
  const MatrixXd& N = independent.motions();
  const auto n = N.rows(), f = N.cols(), y = positions.motions().cols(), p = d.residual_p.cols(),
             z = rates.value.size(), all = y + f + p;
  Reduced out;
  out.coordinates = static_cast<int>(y);
  out.speeds = static_cast<int>(f);
  out.states = static_cast<int>(z);
  out.inputs = static_cast<int>(p - z);
  const std::vector<int>& free = independent.coordinates();
  MatrixXd mass = N.transpose() * d.mass * N;
  massless = massless_coordinate(mass, scales_of(scales.coordinates)(free));
  if (massless >= 0) {
    massless = free[static_cast<std::size_t>(massless)];
    return out;
  }
  // Columns: y, s, parameters.
  MatrixXd position = MatrixXd::Zero(n, all), velocity = position;
  position.leftCols(y) = positions.motions();
  position.rightCols(p) = positions.particular(-d.phi_p);
  MatrixXd rate = product(d.rate_q, position);
  rate.rightCols(p) += d.rate_p;
  velocity = independent.particular(-rate);
  velocity.middleCols(y, f) += N;
  MatrixXd second = product(d.second_q, position) + product(d.second_v, velocity);
  second.rightCols(p) += d.second_p;
  MatrixXd acceleration = independent.particular(-second);
  MatrixXd force =
      product(d.mass, acceleration) + product(d.residual_q, position) + product(d.residual_v, velocity);
  force.rightCols(p) += d.residual_p;
  const MatrixXd reduced_force = N.transpose() * force;
  MatrixXd alpha(f, all);
  if (f > 0) alpha = -solve(mass, reduced_force);
  const MatrixXd relative = N * alpha;
  acceleration += relative;
  // Rates of x.
  MatrixXd x(y + f + z, all);
  const MatrixXd moved = velocity - product(d.turn, position);
  x.topRows(y) = moved(positions.coordinates(), Eigen::all);
  x.middleRows(y, f) = alpha;
  if (z > 0) {
    MatrixXd seen = product(d.seen_q, position) + product(d.seen_v, velocity);
    seen.rightCols(p) += d.seen_p;
    x.bottomRows(z) = rates.by_seen * seen;
    x.bottomRightCorner(z, p) += rates.by_parameters;
  }
  out.A = x.leftCols(y + f + z);
  out.B = x.rightCols(p - z);
  force += d.mass * relative;
  out.multipliers = independent.multipliers(MatrixXd(-force));
  out.position = std::move(position);
  out.velocity = std::move(velocity);
  out.acceleration = std::move(acceleration);
  const MatrixXd by_y = reduced_force.leftCols(y), by_s = reduced_force.middleCols(y, f);
  out.damping = by_s;
  out.stiffness = by_y;
  if (y == f) {
    // s = ẏ + W y, so that M ṡ + C s + K y gives the second-order form.
    const MatrixXd turn = (d.turn * N)(free, Eigen::all);
    out.damping += mass * turn;
    out.stiffness += by_s * turn;
  }
  out.mass = std::move(mass);
  return out;
}

}  // namespace mimbre::linear
