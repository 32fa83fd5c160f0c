#include "integrate/statics.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include "integrate/initial.h"
#include "math/once/decompositions.h"

namespace mimbre {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// Shares of the scales of coordinates, equations, and of the work that the forces at play do along those.
constexpr double difference = 1e-6;        ///< of coordinates, for the tangent
constexpr double furthest_step = 0.3;      ///< that the tangent is trusted with
constexpr double still = 1e-10;            ///< of the last step and of violations
constexpr double balanced_share = 1e-8;    ///< of forces that balance but for this
constexpr double round_off_share = 1e-15;  ///< of the forces that a coordinate's scale causes, at once
constexpr double negligible = 1e-9;        ///< of equations: what moves them by less moves nothing
constexpr double light = 1e-9;             ///< of the largest inertia: what is lighter moves as readily

/// τ in the mechanism's own times: at first, at least, at most, and from which on its steps are Newton's.
constexpr double first_time = 0.2, least_time = 4e-3, longest_time = 400, newton_time = 4;

/// A disturbance that grows by e in no less than 3000 of the mechanism's own times is neutral.
constexpr double neutral = 1e-7;

/// The mechanism in units in which its coordinates and equations are near one: q in its own scales, forces as
/// work along them.
struct Units {
  VectorXd coordinates;
  double energy = 0;  ///< J, of the forces at play
  double pace = 0;    ///< 1/s: how fast they would move it through its scale
};

Units units_of(const System& system, const MatrixXd& mass, const VectorXd& work) {
  const Scales& scales = system.scales();
  Units units;
  units.coordinates = Eigen::Map<const VectorXd>(scales.coordinates.data(), system.velocities());
  const double inertia = mass.rows() > 0 ? mass.diagonal().cwiseAbs().maxCoeff() : 0,
               largest = work.size() > 0 ? work.cwiseAbs().maxCoeff() : 0;
  const double weight = inertia * scales.acceleration;
  units.energy = weight > 0 ? weight : largest;
  units.pace = inertia > 0 && units.energy > 0 ? std::sqrt(units.energy / inertia) : 1;
  return units;
}

/// Growth of disturbances of an equilibrium with the tangent stiffness K along the motions N, all in the
/// mechanism's units.
void judge_stability(const MatrixXd& K, const MatrixXd& mass, const MatrixXd& N, const Units& units,
                     StaticsStatus& status) {
  if (N.cols() == 0) return;
  const MatrixXd stiffness = N.transpose() * K * N;
  MatrixXd inertia = N.transpose() * mass * N;
  const double largest = inertia.diagonal().cwiseAbs().maxCoeff();
  inertia.diagonal().array() += 1e-12 * largest;
  const EigenPairs pairs = symmetric_eigen((stiffness + stiffness.transpose()) / 2, inertia);
  if (!pairs.ok || pairs.values.size() == 0) return;
  // Differences of forces are not sharper than this, and what grows that slowly is neutral.
  const VectorXd x = N * pairs.vectors.col(0);
  const double sharp =
      1e-7 * x.cwiseAbs().dot(K.cwiseAbs() * x.cwiseAbs()) + 1e-9 * units.energy * x.squaredNorm();
  const double slow = neutral * units.pace * units.pace;
  if (-x.dot(K * x) <= sharp || pairs.values[0] >= -slow) return;
  double least = pairs.values[0];
  // What acts one way only, a signal's feedforward or sliding friction, makes K unsymmetric: then its own
  // eigenvalues decide, of which a negative one is a disturbance that grows without turning back.
  if ((stiffness - stiffness.transpose()).norm() > 1e-6 * stiffness.norm()) {
    const Eigen::VectorXcd values = eigenvalues(solve(inertia, stiffness));
    const double round_off = 1e-9 * values.cwiseAbs().maxCoeff();
    least = 0;
    for (const std::complex<double>& value : values)
      if (std::abs(value.imag()) <= round_off) least = std::min(least, value.real());
    if (least >= -std::max(slow, round_off)) return;
  }
  status.growth = std::sqrt(-least);
  x.cwiseAbs().maxCoeff(&status.growing);
}

/// By implicit steps of time τ without velocities, longer as forces get smaller. `careful`: shorter, too,
/// where one leads too far; for friction that slides, which leaves directions without stiffness.
StaticsStatus search(System& system, State& s, bool careful) {
  const int n = system.velocities(), m = system.equations();
  const Scales& scales = system.scales();
  StaticsStatus status;
  s.v.setZero(n);
  s.a.setZero(n);
  s.algorithmic.setZero(n);
  if (s.multipliers.size() != m) s.multipliers.setZero(m);
  const VectorXd zero = VectorXd::Zero(n);
  const VectorXd scale = Eigen::Map<const VectorXd>(scales.coordinates.data(), n);
  VectorXd q_try(system.positions()), unit = zero;
  // The work that is not balanced, along the scales of the coordinates.
  const auto forces = [&](const VectorXd& q, const VectorXd& a) {
    VectorXd r(n);
    system.residual(s.time, q.data(), zero.data(), a.data(), s.multipliers.data(), 0, r.data());
    return VectorXd(scale.cwiseProduct(r));
  };
  const auto violation = [&] { return m == 0 ? 0.0 : scales.of_equations(system.phi()); };

  system.begin_step(s.q.data());
  VectorXd r = forces(s.q, zero);
  MatrixXd mass(n, n);
  for (int k = 0; k < n; ++k) {
    unit[k] = scale[k];
    mass.col(k) = forces(s.q, unit) - r;
    unit[k] = 0;
  }
  const Units units = units_of(system, mass, r);
  // Back onto the constraints with the least motion by mass.
  const double heaviest = n > 0 ? mass.diagonal().maxCoeff() : 0;
  VectorXd lightness = VectorXd::Ones(n);
  if (heaviest > 0) lightness = (mass.diagonal() / heaviest).cwiseMax(light).cwiseSqrt().cwiseInverse();
  const VectorXd readiness = lightness.cwiseProduct(scale);
  const double negligible_work = balanced_share * units.energy;
  const double closed = std::max(still, 10 * scales.round_off);
  double round_off = 0;  // of elastic forces
  double tau = first_time / units.pace, previous = r.norm();
  const double least = least_time / units.pace, most = longest_time / units.pace;
  bool too_far = false;
  for (status.iterations = 0; status.iterations < 400; ++status.iterations) {
    // Onto the constraints, and the multipliers that balance the forces best: whatever equations are
    // redundant, both are determined.
    if (m > 0) {
      close_positions(system, s.time, readiness, s.q, 30, negligible);
      find_multipliers(system, s, negligible);
    }
    r = forces(s.q, zero);
    const double off = violation();
    if (m > 0) scales.of_kinds(system.phi(), status.position_violation, status.angle_violation);
    const double norm = r.norm();
    const double unbalanced = n == 0 ? 0 : r.cwiseAbs().maxCoeff(&status.coordinate);
    if (n > 0) status.residual = unbalanced / scale[status.coordinate];
    if (!std::isfinite(norm)) return status;
    const bool balanced = unbalanced <= std::max(negligible_work, round_off);
    if (careful && too_far)
      tau = std::max(furthest_step * tau, least);
    else if (status.iterations > 0)
      tau = std::clamp(tau * (balanced || norm == 0 ? 10.0 : std::clamp(previous / norm, 0.5, 10.0)), least,
                       most);
    previous = norm;

    MatrixXd tangent(n, n);
    for (int k = 0; k < n; ++k) {
      unit[k] = difference * scale[k];
      system.retract(s.q.data(), unit.data(), q_try.data());
      const VectorXd plus = forces(q_try, zero);
      unit[k] *= -1;
      system.retract(s.q.data(), unit.data(), q_try.data());
      tangent.col(k) = (plus - forces(q_try, zero)) / (2 * difference);
      unit[k] = 0;
    }
    round_off = n == 0 ? 0 : round_off_share * tangent.cwiseAbs().maxCoeff();
    // Along the motions that the constraints leave: x = N z, Φz N = 0.
    MatrixXd motions = MatrixXd::Identity(n, n);
    if (m > 0) {
      const VectorXd rows = Eigen::Map<const VectorXd>(scales.equations.data(), m).cwiseInverse();
      const MatrixXd jacobian = rows.asDiagonal() * dense_jacobian(system, s.time, s.q) * scale.asDiagonal();
      if (n > 0 && jacobian.cwiseAbs().maxCoeff() > negligible) motions = null_space(jacobian, 1e-9);
    }
    VectorXd step = zero;
    if (motions.cols() > 0)
      step = -motions *
             solve(motions.transpose() * (tangent + mass / (tau * tau)) * motions, motions.transpose() * r);
    if (!step.allFinite()) return status;
    const double largest = n == 0 ? 0 : step.cwiseAbs().maxCoeff();
    if (tau * units.pace >= newton_time && balanced && largest < still && off < closed) {
      status.converged = true;
      judge_stability(tangent, mass, motions, units, status);
      break;
    }
    too_far = largest > furthest_step;
    if (too_far) step *= furthest_step / largest;
    step = step.cwiseProduct(scale).eval();
    system.retract(s.q.data(), step.data(), s.q.data());
  }
  return status;
}

}  // namespace

StaticsStatus find_equilibrium(System& system, State& s) {
  const State start = s;
  const StaticsStatus status = search(system, s, false);
  if (status.converged) return status;
  State other = start;
  StaticsStatus next = search(system, other, true);
  if (!next.converged) return status;
  next.iterations += status.iterations;
  s = std::move(other);
  return next;
}

}  // namespace mimbre
