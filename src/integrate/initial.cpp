#include "integrate/initial.h"
#include "linalg/sparse_qr.h"
#include "math/decompositions.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace mimbre {
namespace {

using Eigen::Map;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd copy(const double* x, int n) { return Map<const VectorXd>(x, n); }

/// What an equation adds to others, as a share of the largest, when it is redundant.
constexpr double same = 1e-9;

/// Up to this many entries dense decompositions are fast enough, and the sharper judges of what is redundant.
constexpr std::ptrdiff_t dense_entries = 40000;

/// Smallest x, scaled by the weights, with J x = b in the sense of least squares; `damping` > 0 gives up a
/// part of directions that J hardly sees (Levenberg, Marquardt): those with J² < damping.
VectorXd least_change(const MatrixXd& jacobian, const VectorXd& weight, const VectorXd& b, double damping = 0,
                      double negligible = 1e-13) {
  const MatrixXd scaled = jacobian * weight.asDiagonal();
  // Round-off where nothing can change: the threshold below is relative.
  if (scaled.size() == 0 || scaled.cwiseAbs().maxCoeff() < negligible) return VectorXd::Zero(scaled.cols());
  if (damping > 0) {
    const Eigen::Index m = scaled.rows(), n = scaled.cols();
    MatrixXd extended(m + n, n);
    extended << scaled, std::sqrt(damping) * MatrixXd::Identity(n, n);
    VectorXd right(m + n);
    right << b, VectorXd::Zero(n);
    return weight.asDiagonal() * least_squares(extended, right);
  }
  return weight.asDiagonal() * shortest_solution(scaled, b, same);
}

/// The same without damping for large systems, with J at q: equations that depend on others are left out.
VectorXd sparse_least_change(System& system, double t, const VectorXd& q, const VectorXd& weight,
                             const VectorXd& b) {
  const int n = system.velocities(), m = system.equations();
  const VectorXd zero = VectorXd::Zero(n), none = VectorXd::Zero(m);
  VectorXd r(n);
  system.residual(t, q.data(), zero.data(), zero.data(), none.data(), 0, r.data());
  system.factor(q.data(), {});
  std::vector<Eigen::Triplet<double>> entries;
  for (const JacobianEntry& e : system.jacobian_entries())
    if (const double value = e.value * weight[e.coordinate]; value != 0)
      entries.emplace_back(e.coordinate, e.equation, value);
  linalg::SparseMatrix transposed(n, m);
  transposed.setFromTriplets(entries.begin(), entries.end());
  double longest = 0;
  for (int k = 0; k < m; ++k) longest = std::max(longest, transposed.col(k).norm());
  if (longest < 1e-13) return zero;
  return weight.cwiseProduct(linalg::SparseQr(transposed, same * longest).shortest(b));
}

/// Least change of the coordinates that makes up for `b`.
VectorXd change_of(System& system, double t, const VectorXd& q, const VectorXd& weight, const VectorXd& b,
                   double damping = 0, double negligible = 1e-13) {
  const std::ptrdiff_t entries = static_cast<std::ptrdiff_t>(system.velocities()) * system.equations();
  if (damping == 0 && entries > dense_entries) return sparse_least_change(system, t, q, weight, b);
  return least_change(dense_jacobian(system, t, q), weight, b, damping, negligible);
}

}  // namespace

MatrixXd dense_jacobian(System& system, double t, const VectorXd& q) {
  const int n = system.velocities(), m = system.equations();
  const VectorXd zero = VectorXd::Zero(n), none = VectorXd::Zero(m);
  VectorXd r(n);
  system.residual(t, q.data(), zero.data(), zero.data(), none.data(), 0, r.data());
  system.factor(q.data(), {});
  MatrixXd jacobian(m, n);
  VectorXd unit = zero;
  for (int k = 0; k < n; ++k) {
    unit[k] = 1;
    system.jacobian_times(unit.data(), jacobian.col(k).data());
    unit[k] = 0;
  }
  return jacobian;
}

double close_positions(System& system, double t, const VectorXd& weight, VectorXd& q, double caution,
                       double negligible) {
  const int n = system.velocities(), m = system.equations();
  if (m == 0) return 0;
  const VectorXd zero = VectorXd::Zero(n);
  double violation = 0;
  for (int iteration = 0; iteration < 60; ++iteration) {
    system.kinematics(t, q.data(), zero.data(), zero.data());
    const VectorXd phi = copy(system.phi(), m);
    violation = phi.cwiseAbs().maxCoeff();
    if (!(violation > 1e-13)) break;
    const double damping = violation > 1e-8 ? caution * violation : 0;
    VectorXd x = change_of(system, t, q, weight, -phi, damping, negligible);
    const double length = x.norm();
    if (!(length > 1e-15)) break;
    if (length > 0.5) x *= 0.5 / length;
    system.retract(q.data(), x.data(), q.data());
  }
  return violation;
}

double close_velocities(System& system, double t, const VectorXd& q, const VectorXd& weight, VectorXd& v) {
  const int n = system.velocities(), m = system.equations();
  if (m == 0) return 0;
  const VectorXd zero = VectorXd::Zero(n);
  double violation = 0;
  for (int round = 0; round < 3; ++round) {
    system.kinematics(t, q.data(), v.data(), zero.data());
    const VectorXd phi_dot = copy(system.phi_dot(), m);
    violation = phi_dot.cwiseAbs().maxCoeff();
    if (violation == 0) break;
    if (round < 2) v += change_of(system, t, q, weight, -phi_dot);
  }
  return violation;
}

void find_multipliers(System& system, State& s, double negligible) {
  const int n = system.velocities(), m = system.equations();
  s.multipliers.setZero(m);
  if (m == 0) return;
  const MatrixXd jacobian = dense_jacobian(system, s.time, s.q);
  VectorXd r(n);
  system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
  s.multipliers = least_change(jacobian.transpose(), VectorXd::Ones(m), -r, 0, negligible);
}

bool solve_accelerations(System& system, State& s) {
  const int n = system.velocities(), m = system.equations();
  s.a.setZero(n);
  s.multipliers.setZero(m);
  const double penalty = 1e6;
  VectorXd r(n), g(m), jd(m);
  for (int round = 0; round < 60; ++round) {
    system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
    if (round == 0 && !system.factor(s.q.data(), {0, 0, penalty}).ok()) return false;
    for (int k = 0; k < m; ++k) g[k] = penalty * system.penalty()[k] * system.phi_ddot()[k];
    system.add_jacobian_transposed(g.data(), 1, r.data());
    r = -r;
    system.solve(r.data());
    s.a += r;
    system.jacobian_times(r.data(), jd.data());
    for (int k = 0; k < m; ++k) s.multipliers[k] += g[k] + penalty * system.penalty()[k] * jd[k];
    if (!r.allFinite()) return false;
    if (n == 0 || r.cwiseAbs().maxCoeff() <= 1e-10 * std::max(1.0, s.a.cwiseAbs().maxCoeff())) break;
  }
  s.algorithmic = s.a;
  return s.a.allFinite();
}

}  // namespace mimbre
