#include "integrate/statics.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include "integrate/initial.h"
#include "math/decompositions.h"

namespace mimbre {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Growth of disturbances of an equilibrium with the tangent stiffness K along the motions N.
void judge_stability(const MatrixXd& K, const MatrixXd& mass, const MatrixXd& N, double force,
                     StaticsStatus& status) {
  if (N.cols() == 0) return;
  const MatrixXd stiffness = N.transpose() * K * N;
  MatrixXd inertia = N.transpose() * mass * N;
  const double largest = inertia.diagonal().cwiseAbs().maxCoeff();
  inertia.diagonal().array() += 1e-12 * largest;
  const EigenPairs pairs = symmetric_eigen((stiffness + stiffness.transpose()) / 2, inertia);
  if (!pairs.ok || pairs.values.size() == 0) return;
  // Differences of forces are not sharper than this, and what takes a quarter of an hour is neutral.
  const VectorXd x = N * pairs.vectors.col(0);
  const double sharp = 1e-7 * x.cwiseAbs().dot(K.cwiseAbs() * x.cwiseAbs()) + 1e-9 * force * x.squaredNorm();
  if (-x.dot(K * x) <= sharp || pairs.values[0] >= -1e-6) return;
  double least = pairs.values[0];
  // What acts one way only, a signal's feedforward or sliding friction, makes K unsymmetric: then its own
  // eigenvalues decide, of which a negative one is a disturbance that grows without turning back.
  if ((stiffness - stiffness.transpose()).norm() > 1e-6 * stiffness.norm()) {
    const Eigen::VectorXcd values = eigenvalues(solve(inertia, stiffness));
    const double round_off = 1e-9 * values.cwiseAbs().maxCoeff();
    least = 0;
    for (const std::complex<double>& value : values)
      if (std::abs(value.imag()) <= round_off) least = std::min(least, value.real());
    if (least >= -std::max(1e-6, round_off)) return;
  }
  status.growth = std::sqrt(-least);
  x.cwiseAbs().maxCoeff(&status.growing);
}

/// By implicit steps of time τ without velocities, longer as forces get smaller. `careful`: shorter, too,
/// where one leads too far; for friction that slides, which leaves directions without stiffness.
StaticsStatus search(System& system, State& s, double length, bool careful) {
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
  // Back onto the constraints with the least motion by mass: coordinates have different units.
  const VectorXd inertia = mass.diagonal().cwiseMax(1e-9 * std::max(1e-300, mass.diagonal().maxCoeff()));
  const VectorXd lightness = (inertia / inertia.maxCoeff()).cwiseSqrt().cwiseInverse();
  // Typical force of a coordinate, to make residuals comparable.
  const double weight = std::max(1e-12, (mass.diagonal().cwiseAbs().maxCoeff() + 1e-6) * 9.81);
  const double negligible = 1e-9 * length;
  double round_off = 0;  // of elastic forces
  double tau = 0.05, previous = r.norm();
  bool too_far = false;
  for (status.iterations = 0; status.iterations < 400; ++status.iterations) {
    // Onto the constraints, and the multipliers that balance the forces best: whatever equations are
    // redundant, both are determined.
    if (m > 0) {
      close_positions(system, s.time, lightness, s.q, 30, negligible);
      find_multipliers(system, s, negligible);
    }
    r = forces(s.q, zero);
    status.violation = violation();
    const double norm = r.norm();
    status.residual = n == 0 ? 0 : r.cwiseAbs().maxCoeff(&status.coordinate);
    if (!std::isfinite(norm)) return status;
    const bool balanced = status.residual < std::max(1e-8 * weight, round_off);
    if (careful && too_far)
      tau = std::max(0.3 * tau, 1e-3);
    else if (status.iterations > 0)
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
      const MatrixXd jacobian = dense_jacobian(system, s.time, s.q);
      if (n > 0 && jacobian.cwiseAbs().maxCoeff() > negligible) motions = null_space(jacobian, 1e-9);
    }
    VectorXd step = zero;
    if (motions.cols() > 0)
      step = -motions * solve(motions.transpose() * tangent * motions, motions.transpose() * r);
    if (!step.allFinite()) return status;
    const double largest = n == 0 ? 0 : step.cwiseAbs().maxCoeff();
    if (tau >= 1 && balanced && largest < 1e-10 && status.violation < 1e-10) {
      status.converged = true;
      judge_stability(tangent - mass / (tau * tau), mass, motions, weight, status);
      break;
    }
    too_far = largest > 0.3;
    if (too_far) step *= 0.3 / largest;
    system.retract(s.q.data(), step.data(), s.q.data());
  }
  return status;
}

}  // namespace

StaticsStatus find_equilibrium(System& system, State& s, double length) {
  const State start = s;
  const StaticsStatus status = search(system, s, length, false);
  if (status.converged) return status;
  State other = start;
  StaticsStatus next = search(system, other, length, true);
  if (!next.converged) return status;
  next.iterations += status.iterations;
  s = std::move(other);
  return next;
}

}  // namespace mimbre
