#include "integrate/statics.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "integrate/initial.h"
#include "math/decompositions.h"

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
  double round_off = 0;  // of elastic forces
  double tau = 0.05, previous = r.norm();
  for (status.iterations = 0; status.iterations < 400; ++status.iterations) {
    // Onto the constraints, and the multipliers that balance the forces best: whatever equations are
    // redundant, both are determined.
    if (m > 0) {
      close_positions(system, s.time, VectorXd::Ones(n), s.q, 30);
      find_multipliers(system, s);
    }
    r = forces(s.q, zero);
    status.violation = violation();
    const double norm = r.norm();
    status.residual = n == 0 ? 0 : r.cwiseAbs().maxCoeff();
    if (!std::isfinite(norm)) return status;
    const bool balanced = status.residual < std::max(1e-8 * weight, round_off);
    if (status.iterations > 0)
      tau = std::clamp(tau * (balanced ? 10.0 : std::clamp(previous / std::max(norm, 1e-300), 0.5, 10.0)),
                       1e-3, 100.0);
    previous = norm;

    MatrixXd tangent = mass / (tau * tau);
    const double eps = 1e-6;
    for (int k = 0; k < n; ++k) {
      unit[k] = eps;
      system.retract(s.q.data(), unit.data(), q_try.data());
      const VectorXd plus = forces(q_try, zero);
      unit[k] = -eps;
      system.retract(s.q.data(), unit.data(), q_try.data());
      tangent.col(k) += (plus - forces(q_try, zero)) / (2 * eps);
      unit[k] = 0;
    }
    round_off = 1e-15 * (tangent - mass / (tau * tau)).cwiseAbs().maxCoeff();
    // Along the motions that the constraints leave: x = N z, Φz N = 0.
    MatrixXd motions = MatrixXd::Identity(n, n);
    if (m > 0) {
      motions = null_space(dense_jacobian(system, s.time, s.q), 1e-9);
    }
    VectorXd step = zero;
    if (motions.cols() > 0)
      step = -motions * solve(motions.transpose() * tangent * motions, motions.transpose() * r);
    if (!step.allFinite()) return status;
    const double largest = n == 0 ? 0 : step.cwiseAbs().maxCoeff();
    if (tau >= 1 && balanced && largest < 1e-10 && status.violation < 1e-10) {
      status.converged = true;
      break;
    }
    if (largest > 0.3) step *= 0.3 / largest;
    system.retract(s.q.data(), step.data(), s.q.data());
  }
  return status;
}

}  // namespace mimbre
