#include "analysis/equilibria/path_place.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <utility>

#include "math/once/decompositions.h"

namespace mimbre {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// Corrections that end the iterations: at once, or where they do not get smaller any more.
constexpr double corrected_path = 1e-11, nearly_corrected_path = 1e-8;
constexpr int most_path_corrections = 12;
constexpr double dependent = 1e-9;         ///< pivots of equations of about one: paths cross
constexpr double no_resistance = 1e-10;    ///< of eigenvalues of about one
constexpr double neutral_band = 1e-8;      ///< likewise: round-off of what resists nothing
constexpr double unsymmetric_path = 1e-6;  ///< of the stiffness
constexpr double no_size = 1e-12;          ///< of what coordinates resist, by the largest
constexpr double no_work = 1e-6;  ///< how far loads over their range move a motion of usual stiffness
constexpr double shortest_reach = 1e-6;

}  // namespace

bool PathPlaces::look(PathPlace& place) {
  place.tangent = equations_.at(place.state, place.factor);
  const PathTangent& t = place.tangent;
  return t.stiffness.allFinite() && t.force.allFinite() && t.load.allFinite();
}

void PathPlaces::measure(const PathPlace& place) {
  const PathTangent& t = place.tangent;
  sizes_ = VectorXd::Zero(t.motions.rows());
  for (std::size_t k = 0; k < t.coordinates.size(); ++k)
    sizes_[t.coordinates[k]] = std::abs(t.stiffness(static_cast<Index>(k), static_cast<Index>(k)));
  const double largest = sizes_.maxCoeff();
  for (double& size : sizes_) {
    if (!(largest > 0)) size = 1;
    // Those that depend on others here, too.
    if (!(size > no_size * largest)) size = largest > 0 ? (size > 0 ? no_size * largest : largest) : 1;
  }
}

/// By independent coordinate, 1/√size.
VectorXd PathPlaces::units(const PathTangent& t) const {
  VectorXd out(t.force.size());
  for (Index k = 0; k < out.size(); ++k)
    out[k] = 1 / std::sqrt(sizes_[t.coordinates[static_cast<std::size_t>(k)]]);
  return out;
}

bool PathPlaces::judge(PathPlace& place) const {
  const VectorXd unit = units(place.tangent);
  const MatrixXd K = unit.asDiagonal() * place.tangent.stiffness * unit.asDiagonal();
  place.symmetric = (K - K.transpose()).norm() <= unsymmetric_path * K.norm();
  place.unstable = place.negative = 0;
  if (place.symmetric) {
    place.eigenvalues = symmetric_eigenvalues((K + K.transpose()) / 2);
    if (place.eigenvalues.size() != K.rows() || !place.eigenvalues.allFinite()) return false;
    for (const double x : place.eigenvalues) place.unstable += x < -neutral_band ? 1 : 0;
    place.negative = place.unstable;
    return true;
  }
  place.eigenvalues.resize(0);
  const Eigen::VectorXcd values = mimbre::eigenvalues(K);
  if (values.size() != K.rows()) return false;
  for (const std::complex<double>& x : values) {
    if (!(x.real() < -neutral_band)) continue;
    ++place.unstable;
    if (x.imag() == 0) ++place.negative;
  }
  return true;
}

PathPlaces::Bordered PathPlaces::bordered(const PathTangent& t, const PathDirection& across) const {
  const Index f = t.force.size();
  const VectorXd unit = units(t);
  Bordered out;
  MatrixXd& A = out.matrix;
  A = MatrixXd::Zero(f + 1, f + 1);
  A.topLeftCorner(f, f) = unit.asDiagonal() * t.stiffness * unit.asDiagonal();
  A.topRightCorner(f, 1) = unit.cwiseProduct(t.load) * range_;
  A.bottomLeftCorner(1, f) = unit.cwiseProduct(t.motions.transpose() * across.motion).transpose();
  A(f, f) = across.factor;
  out.rows.resize(f + 1);
  out.columns.resize(f + 1);
  out.rows.head(f) = out.columns.head(f) = unit;
  const double row = A.row(f).norm();
  out.rows[f] = row > 0 ? 1 / row : 1;
  A.row(f) *= out.rows[f];
  const double column = A.col(f).norm();
  out.columns[f] = column > 0 ? 1 / column : 1;
  A.col(f) *= out.columns[f];
  return out;
}

std::optional<PathPlace> PathPlaces::corrected(State state, double factor, const PathDirection& across,
                                               double reach, int* corrections) {
  PathPlace place;
  place.state = std::move(state);
  place.factor = factor;
  double before = std::numeric_limits<double>::infinity(), sum = 0;
  for (int k = 0; k < most_path_corrections; ++k) {
    if (!look(place)) return {};
    const PathTangent& t = place.tangent;
    const Index f = t.force.size();
    const Bordered b = bordered(t, across);
    VectorXd right = VectorXd::Zero(f + 1);
    right.head(f) = -b.rows.head(f).cwiseProduct(t.force);
    const VectorXd x = b.columns.cwiseProduct(VectorXd(shortest_solution(b.matrix, right, dependent)));
    if (!x.allFinite()) return {};
    const PathDirection step{t.motions * x.head(f), x[f]};
    const double size = step.largest();
    if ((sum += size) > std::max(reach, shortest_reach)) return {};
    if (!equations_.move(place.state, step.motion)) return {};
    place.factor += step.factor * range_;
    if (size <= corrected_path || (size <= nearly_corrected_path && size > before / 2)) {
      if (corrections) *corrections = k + 1;
      // The last position but one is as near.
      return judge(place) ? std::optional(std::move(place)) : std::nullopt;
    }
    before = size;
  }
  return {};
}

std::optional<PathPlace> PathPlaces::ahead(const PathPlace& from, const PathDirection& along, double length,
                                           double reach, int* corrections) {
  State state = from.state;
  if (!equations_.move(state, length * along.motion)) return {};
  return corrected(std::move(state), from.factor + length * along.factor * range_, along, reach * length,
                   corrections);
}

std::optional<PathPlace> PathPlaces::at_factor(const PathPlace& near, double factor, double reach) {
  return corrected(near.state, factor, {VectorXd::Zero(near.tangent.motions.rows()), 1}, reach, nullptr);
}

std::optional<PathDirection> PathPlaces::direction(const PathPlace& at, const PathDirection& like) const {
  const PathTangent& t = at.tangent;
  const Index f = t.force.size();
  const Bordered b = bordered(t, like);
  const VectorXd x =
      b.columns.cwiseProduct(VectorXd(shortest_solution(b.matrix, VectorXd::Unit(f + 1, f), dependent)));
  if (!x.allFinite()) return {};
  PathDirection out{t.motions * x.head(f), x[f]};
  const double length = out.length();
  if (!(length > 0) || !std::isfinite(length)) return {};
  out.motion /= length;
  out.factor /= length;
  return out;
}

std::tuple<VectorXd, VectorXd, double> PathPlaces::motion(const PathPlace& place, int number) const {
  const VectorXd unit = units(place.tangent);
  const MatrixXd K = unit.asDiagonal() * place.tangent.stiffness * unit.asDiagonal();
  if (place.symmetric) {
    const EigenPairs pairs = symmetric_eigen((K + K.transpose()) / 2);
    if (!pairs.ok) return {};
    Index at = number;
    if (number < 0) pairs.values.cwiseAbs().minCoeff(&at);
    const VectorXd along = unit.cwiseProduct(pairs.vectors.col(at));
    return {along, along, std::abs(pairs.values[at])};
  }
  // The least eigenvalue of Kᵀ K and of K Kᵀ is the square of the least singular value.
  const EigenPairs right = symmetric_eigen(K.transpose() * K), left = symmetric_eigen(K * K.transpose());
  if (!right.ok || !left.ok) return {};
  return {unit.cwiseProduct(right.vectors.col(0)), unit.cwiseProduct(left.vectors.col(0)),
          std::sqrt(std::max(0.0, right.values[0]))};
}

bool PathPlaces::works(const PathPlace& place, const VectorXd& left) const {
  return std::abs(left.dot(place.tangent.load) * range_) * left.cwiseAbs().maxCoeff() > no_work;
}

VectorXd PathPlaces::without_stiffness(const PathPlace& place) const {
  const auto [along, left, size] = motion(place);
  return along.size() > 0 && size <= no_resistance ? along : VectorXd();
}

}  // namespace mimbre
