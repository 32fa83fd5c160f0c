#include "integrate/initial.h"
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

/// Smallest x, scaled by the weights, with J x = b in the sense of least squares; `damping` > 0 gives up a
/// part of directions that J hardly sees (Levenberg, Marquardt): those with J² < damping.
VectorXd least_change(const MatrixXd& jacobian, const VectorXd& weight, const VectorXd& b,
                      double damping = 0) {
  const MatrixXd scaled = jacobian * weight.asDiagonal();
  if (damping > 0) {
    const Eigen::Index m = scaled.rows(), n = scaled.cols();
    MatrixXd extended(m + n, n);
    extended << scaled, std::sqrt(damping) * MatrixXd::Identity(n, n);
    VectorXd right(m + n);
    right << b, VectorXd::Zero(n);
    return weight.asDiagonal() * least_squares(extended, right);
  }
  // Round-off where nothing can change: the threshold below is relative.
  if (scaled.size() == 0 || scaled.cwiseAbs().maxCoeff() < 1e-13) return VectorXd::Zero(scaled.cols());
  return weight.asDiagonal() * shortest_solution(scaled, b, 1e-9);
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

double close_positions(System& system, double t, const VectorXd& weight, VectorXd& q, double caution) {
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
    VectorXd x = least_change(dense_jacobian(system, t, q), weight, -phi, damping);
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
  const MatrixXd jacobian = dense_jacobian(system, t, q);
  double violation = 0;
  for (int round = 0; round < 3; ++round) {
    system.kinematics(t, q.data(), v.data(), zero.data());
    const VectorXd phi_dot = copy(system.phi_dot(), m);
    violation = phi_dot.cwiseAbs().maxCoeff();
    if (violation == 0) break;
    if (round < 2) v += least_change(jacobian, weight, -phi_dot);
  }
  return violation;
}

void find_multipliers(System& system, State& s) {
  const int n = system.velocities(), m = system.equations();
  s.multipliers.setZero(m);
  if (m == 0) return;
  const MatrixXd jacobian = dense_jacobian(system, s.time, s.q);
  VectorXd r(n);
  system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
  s.multipliers = least_change(jacobian.transpose(), VectorXd::Ones(m), -r);
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
