#include <algorithm>

#include "math/once/decompositions.h"
#include "simulation/watch/lag.h"
#include "simulation/watch/mechanism_response.h"

namespace mimbre {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Squares of frequencies over the largest: motions that the mechanism does not permit.
constexpr double not_permitted = 1e-12;
/// Coordinates of a mechanism that is looked at.
constexpr int most_coordinates_of_response = 400;

}  // namespace

MatrixXd response_at(relative::RelativeSystem& system, const State& state) {
  const int n = system.velocities();
  if (n > most_coordinates_of_response) return {};
  const VectorXd rest = VectorXd::Zero(n), none = VectorXd::Zero(system.equations());
  VectorXd r(n);
  system.enter(state.u.data(), state.z.data(), 0);
  system.begin_step(state.q.data());
  system.residual(state.time, state.q.data(), rest.data(), rest.data(), none.data(), 0, r.data());
  MatrixXd mass(n, n);
  system.dense_matrix(state.q.data(), {}, mass.data());
  const std::vector<double>& scales = system.scales().coordinates;
  const VectorXd s = Eigen::Map<const VectorXd>(scales.data(), n);
  mass = (s.asDiagonal() * (0.5 * (mass + mass.transpose())) * s.asDiagonal()).eval();
  MatrixXd motions;
  if (system.equations() > 0) {
    MatrixXd jacobian = MatrixXd::Zero(system.equations(), n);
    for (const JacobianEntry& e : system.jacobian_entries())
      jacobian(e.equation, e.coordinate) += e.value * s[e.coordinate];
    for (Index k = 0; k < jacobian.rows(); ++k)
      if (const double length = jacobian.row(k).norm(); length > 0) jacobian.row(k) /= length;
    motions = null_space(jacobian, 1e-9);
    if (motions.cols() == 0) return MatrixXd::Zero(n, n);
    mass = (motions.transpose() * mass * motions).eval();
  } else {
    motions.setIdentity(n, n);
  }
  const Cholesky factor(mass);
  if (!factor.ok()) return {};
  const MatrixXd root = factor.solve_lower(motions.transpose() * s.asDiagonal());
  return root.transpose() * root;
}

void Lag::set_modes(const MatrixXd& K, const MatrixXd& C, const MatrixXd& amplitudes,
                    const MatrixXd& response) {
  count_ = 0;
  rows_.setZero(most_modes, K.cols());
  own_.setZero();
  damping_.setZero();
  squares_.setOnes();
  if (response.size() == 0 || amplitudes.cols() == 0) return;
  const MatrixXd read = amplitudes.transpose() * K;
  const EigenPairs pairs = symmetric_eigen(read * response * read.transpose());
  if (!pairs.ok) return;
  const Index all = pairs.values.size();
  Index first = 0;
  while (first < all && !(pairs.values[first] > not_permitted * pairs.values[all - 1])) ++first;
  const Index count = std::min<Index>(most_modes, all - first), known = std::min<Index>(most_modes, all);
  const MatrixXd modes = pairs.vectors.middleCols(first, count), shapes = amplitudes * modes;
  rows_.topRows(count) = modes.transpose() * read;
  own_.topLeftCorner(known, count) = modes.topRows(known);
  squares_.head(count) = pairs.values.segment(first, count).cwiseInverse();
  damping_.topLeftCorner(count, count) = shapes.transpose() * C * shapes;
  count_ = static_cast<int>(count);
}

}  // namespace mimbre
