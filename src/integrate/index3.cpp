#include "integrate/index3.h"

#include <algorithm>
#include <cmath>

#include "integrate/newton.h"
#include "integrate/vectors.h"

namespace mimbre {

IndexThree::IndexThree(System& system, const IntegratorOptions& options)
    : Stepper(options),
      system_(system),
      motion_(system, options),
      mixing_(system.velocities(), system.equations()) {
  set_step(options.step);
  const int n = system.velocities(), m = system.equations();
  r_.setZero(n);
  for (Eigen::VectorXd* x : {&lambda_, &impulse_, &g_, &force_}) x->setZero(m);
}

void IndexThree::set_step(double step) {
  options_.step = step;
  motion_.set_step(step);
  // The residual's derivative divided by ∂z̈/∂x.
  weights_ = {motion_.rate * motion_.scale, motion_.scale, options_.penalty};
}

/// Adds to `target` the smallest change, in the norm of W, that brings Φz target to −violation; g_ is its
/// remainder.
void IndexThree::project(double* target, const double* violation, double tolerance) {
  const int n = system_.velocities(), m = system_.equations();
  const double* alpha = system_.penalty();
  std::copy(violation, violation + m, g_.data());
  for (int round = 0; round < 6 && largest(g_.data(), m) > tolerance; ++round) {
    for (int k = 0; k < m; ++k) impulse_[k] = alpha[k] * g_[k];
    r_.setZero();
    system_.add_jacobian_transposed(impulse_.data(), -weights_.penalty, r_.data());
    system_.solve(r_.data());
    for (int k = 0; k < n; ++k) target[k] += r_[k];
    system_.jacobian_times(r_.data(), impulse_.data());
    for (int k = 0; k < m; ++k) {
      g_[k] += impulse_[k];
      force_[k] += weights_.penalty * alpha[k] * g_[k];
    }
  }
}

StepStatus IndexThree::step(State& s) {
  const int n = system_.velocities(), m = system_.equations();
  const double time = s.time + motion_.h;
  const double scale = motion_.scale, penalty_factor = options_.penalty / scale;
  const double* alpha = system_.penalty();
  Eigen::VectorXd &x = motion_.x, &v = motion_.v, &a = motion_.a;
  const Eigen::VectorXd& q = motion_.q;
  StepStatus status;

  system_.begin_step(s.q.data());
  motion_.begin(s);
  lambda_ = s.multipliers;
  const auto fail = [&](StepCode code) {
    status.code = code;
    return status;
  };
  motion_.predict(s);

  double violation = 0;
  bool converged = false, settled = false;
  NewtonProgress newton;
  mixing_.reset();
  for (int iteration = 0; iteration < options_.max_iterations; ++iteration) {
    motion_.from_increment(s);
    system_.residual(time, q.data(), v.data(), a.data(), lambda_.data(), 0, r_.data());
    ++status.iterations;
    violation = largest(system_.phi(), m);
    const double reference = std::max(9.81, largest(a.data(), n));
    if (iteration == 0 && violation > 0.05 * largest(x.data(), n)) {
      // The prediction tears the loops: velocities ring. Start from where the step starts instead.
      x.setZero();
      continue;
    }
    if (iteration == 0 && options_.rule == IntegratorOptions::Rule::newmark &&
        system_.tangent_changed(q.data(), weights_)) {
      // Into an impact, or out of it: Newmark's accelerations ring there and, extrapolated, can lead to
      // another, absurd solution of the step.
      motion_.predict_velocities(s);
      continue;
    }
    const bool fresh = newton.refactor || system_.tangent_changed(q.data(), weights_);
    if (fresh) {
      mixing_.reset();
      const linalg::FactorStatus f = system_.factor(q.data(), weights_);
      ++status.factorisations;
      if (!f.ok()) {
        status.coordinate = f.unknown;
        return fail(find_not_finite(r_.data(), n) >= 0 ? StepCode::not_finite : StepCode::singular);
      }
    }
    // The penalty's force with the Jacobian of the factorised matrix, so that an old matrix still aims at Φ =
    // 0: f δ = −βh² (M z̈ + Φzᵀ λ − Q + Φzᵀ α Φ).
    for (int k = 0; k < m; ++k) impulse_[k] = penalty_factor * alpha[k] * system_.phi()[k];
    system_.add_jacobian_transposed(impulse_.data(), 1, r_.data());
    for (int k = 0; k < n; ++k) r_[k] *= -scale;
    system_.solve(r_.data());
    // The multipliers that balance this correction: λ + α (Φ + Φz δ).
    system_.jacobian_times(r_.data(), impulse_.data());
    // Once the loops are closed the multipliers stay: near singular positions they would creep on for dozens
    // of iterations along directions that hardly act, while the motion does not change any more.
    settled = iteration > 2 && violation <= options_.position_tolerance;
    for (int k = 0; k < m; ++k) force_[k] = penalty_factor * alpha[k] * (system_.phi()[k] + impulse_[k]);
    if (!settled) lambda_ += force_;
    int where = 0;
    status.correction = n > 0 ? r_.cwiseAbs().maxCoeff(&where) : 0;
    status.coordinate = where;
    if (!std::isfinite(status.correction)) {
      status.coordinate = std::max(0, find_not_finite(r_.data(), n));
      return fail(StepCode::not_finite);
    }
    system_.compose(x.data(), r_.data());
    if (newton.slow) mixing_.mix(x, lambda_, r_);

    const double left = newton.add(status.correction, fresh);
    converged = left <= options_.tolerance * scale * reference &&
                violation * std::min(1.0, newton.rate) <= options_.position_tolerance;
    if (converged) {
      motion_.from_increment(s);
      system_.kinematics(time, q.data(), v.data(), a.data());
      status.position_violation = largest(system_.phi(), m);
      if (status.position_violation <= 10 * options_.position_tolerance) break;
      // The rate promised too much.
      converged = false;
      newton.refactor = !newton.slow;
    }
  }
  if (!converged) return fail(StepCode::not_converged);

  // Velocities and accelerations onto the constraints.
  if (m > 0) {
    // Not the penalty's force of the violation that is left, which is round-off times a large number.
    if (settled) lambda_ += force_;
    motion_.algorithmic -= a * ((1 - motion_.rule.alpha_f) / (1 - motion_.rule.alpha_m));
    // The factorised matrix belongs to an earlier iterate, so that a projection leaves a little, which the
    // next removes.
    for (int round = 0; round < 5; ++round) {
      status.velocity_violation = largest(system_.phi_dot(), m);
      if (status.velocity_violation <= (round == 0 ? 1 : 1e2) * options_.velocity_tolerance) break;
      project(v.data(), system_.phi_dot(), options_.velocity_tolerance);
      system_.kinematics(time, q.data(), v.data(), a.data());
    }
    // The multipliers follow the accelerations, so that they balance the projected ones: M δ + Φzᵀ Δλ = 0.
    force_.setZero();
    project(a.data(), system_.phi_ddot(), 1e-6);
    lambda_ += force_;
    motion_.algorithmic += a * ((1 - motion_.rule.alpha_f) / (1 - motion_.rule.alpha_m));
  }
  const int bad = find_not_finite(v.data(), n);
  if (bad >= 0) {
    status.coordinate = bad;
    return fail(StepCode::not_finite);
  }
  motion_.accept(s, lambda_);
  return status;
}

}  // namespace mimbre
