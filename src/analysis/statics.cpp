#include "analysis/statics.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "integrate/initial.h"

namespace mimbre {

using Eigen::MatrixXd;
using Eigen::VectorXd;

StaticsStatus find_equilibrium(System& system, State& s) {
  const int n = system.velocities(), m = system.equations();
  StaticsStatus status;
  s.v.setZero(n);
  s.a.setZero(n);
  s.algorithmic.setZero(n);
  if (s.multipliers.size() != m) s.multipliers.setZero(m);
  const VectorXd zero = VectorXd::Zero(n);
  VectorXd q_try(system.positions()), unit = zero;
  const auto forces = [&](const VectorXd& q, const VectorXd& a) {
    VectorXd r(n);
    system.residual(s.time, q.data(), zero.data(), a.data(), s.multipliers.data(), 0, r.data());
    return r;
  };
  const auto violation = [&] {
    return m == 0 ? 0.0 : Eigen::Map<const VectorXd>(system.phi(), m).cwiseAbs().maxCoeff();
  };

  system.begin_step(s.q.data());
  VectorXd r = forces(s.q, zero);
  MatrixXd mass(n, n);
  for (int k = 0; k < n; ++k) {
    unit[k] = 1;
    mass.col(k) = forces(s.q, unit) - r;
    unit[k] = 0;
  }
  // Typical force of a coordinate, to make residuals comparable.
  const double weight = std::max(1e-12, (mass.diagonal().cwiseAbs().maxCoeff() + 1e-6) * 9.81);
  double tau = 0.05, previous = r.norm();
  for (status.iterations = 0; status.iterations < 400; ++status.iterations) {
    r = forces(s.q, zero);
    status.violation = violation();
    VectorXd phi(m);
    for (int k = 0; k < m; ++k) phi[k] = system.phi()[k];
    const double norm = r.norm();
    status.residual = n == 0 ? 0 : r.cwiseAbs().maxCoeff();
    if (!std::isfinite(norm)) return status;
    if (status.iterations > 0)
      tau = std::clamp(tau * std::clamp(previous / std::max(norm, 1e-300), 0.5, 10.0), 1e-3, 100.0);
    previous = norm;

    MatrixXd system_matrix = MatrixXd::Zero(n + m, n + m);
    const double eps = 1e-6;
    for (int k = 0; k < n; ++k) {
      unit[k] = eps;
      system.retract(s.q.data(), unit.data(), q_try.data());
      system_matrix.col(k).head(n) = forces(q_try, zero);
      unit[k] = -eps;
      system.retract(s.q.data(), unit.data(), q_try.data());
      system_matrix.col(k).head(n) -= forces(q_try, zero);
      unit[k] = 0;
    }
    system_matrix.topLeftCorner(n, n) /= 2 * eps;
    system_matrix.topLeftCorner(n, n) += mass / (tau * tau);
    if (m > 0) {
      const MatrixXd jacobian = dense_jacobian(system, s.time, s.q);
      system_matrix.topRightCorner(n, m) = jacobian.transpose();
      system_matrix.bottomLeftCorner(m, n) = jacobian;
      // Redundant equations stay solvable: multipliers cost a little.
      for (int k = 0; k < m; ++k) system_matrix(n + k, n + k) = -1e-12;
    }
    VectorXd rhs(n + m);
    rhs << -r, -phi;
    const VectorXd x = system_matrix.partialPivLu().solve(rhs);
    if (!x.allFinite()) return status;
    VectorXd step = x.head(n);
    const double largest = n == 0 ? 0 : step.cwiseAbs().maxCoeff();
    if (largest > 0.3) step *= 0.3 / largest;
    system.retract(s.q.data(), step.data(), s.q.data());
    s.multipliers += x.tail(m);
    if (tau >= 1 && largest < 1e-10 && status.residual < 1e-8 * weight && status.violation < 1e-10) {
      status.converged = true;
      break;
    }
  }
  return status;
}

}  // namespace mimbre
