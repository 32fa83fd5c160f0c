#include "integrate/integrator.h"

#include <algorithm>
#include <cmath>

namespace mimbre {
namespace {

double largest(const double* x, int n) {
  double m = 0;
  for (int k = 0; k < n; ++k) m = std::max(m, std::abs(x[k]));
  return m;
}

/// Index of the first value that is not finite, -1 when all are.
int find_not_finite(const double* x, int n) {
  for (int k = 0; k < n; ++k)
    if (!std::isfinite(x[k])) return k;
  return -1;
}

}  // namespace

Integrator::Integrator(System& system, const IntegratorOptions& options)
    : system_(system), options_(options), mixing_(system.velocities(), system.equations()) {
  if (options.newmark) {
    alpha_m_ = alpha_f_ = 0;
    beta_ = (1 - options.xi) * (1 - options.xi) / 4;
    gamma_ = (1 - 2 * options.xi) / 2;
  } else {
    alpha_m_ = (2 * options.rho - 1) / (options.rho + 1);
    alpha_f_ = options.rho / (options.rho + 1);
    gamma_ = 0.5 + alpha_f_ - alpha_m_;
    beta_ = 0.25 * (gamma_ + 0.5) * (gamma_ + 0.5);
  }
  set_step(options.step);
  const int n = system.velocities(), m = system.equations();
  q_.setZero(system.positions());
  for (Eigen::VectorXd* x : {&v_, &a_, &algorithmic_, &start_a_, &start_algorithmic_, &x_, &r_})
    x->setZero(n);
  for (Eigen::VectorXd* x : {&lambda_, &impulse_, &g_, &force_}) x->setZero(m);
}

void Integrator::set_step(double step) {
  options_.step = step;
  // ∂z̈/∂x = (1 − αm)/((1 − αf) β h²): the residual's derivative divided by it.
  const double scale = (1 - alpha_f_) / (1 - alpha_m_) * beta_ * step * step;
  weights_ = {gamma_ / (beta_ * step) * scale, scale, options_.penalty};
}

/// Accelerations W a + Φzᵀ λ = Q, Φ̈ = 0 with W = M + γhC + βh²K instead of M. Where the start is not in
/// balance, stiff modes would start with accelerations that no step of this length can follow and that
/// overshoot by far; W bounds them by what the step can bring about, and changes those of slow motions by
/// terms of the order of the step.
void Integrator::start(const State& s) {
  const int n = system_.velocities(), m = system_.equations();
  const double* alpha = system_.penalty();
  a_.setZero();
  lambda_.setZero();
  for (int round = 0; round < 8; ++round) {
    // r = Q − M a: only the first round's, W a is followed by hand through the corrections.
    if (round == 0) {
      system_.residual(s.time, s.q.data(), s.v.data(), a_.data(), lambda_.data(), 0, r_.data());
      if (!system_.factor(s.q.data(), weights_).ok()) return;
    } else {
      system_.kinematics(s.time, s.q.data(), s.v.data(), a_.data());
      r_.setZero();
    }
    for (int k = 0; k < m; ++k) impulse_[k] = weights_.penalty * alpha[k] * system_.phi_ddot()[k];
    system_.add_jacobian_transposed(impulse_.data(), 1, r_.data());
    for (int k = 0; k < n; ++k) r_[k] = -r_[k];
    system_.solve(r_.data());
    if (find_not_finite(r_.data(), n) >= 0) return;
    a_ += r_;
    if (m == 0) break;
  }
  start_a_ = start_algorithmic_ = a_;
}

/// q, v, a, algorithmic accelerations at the end of the step that moves by x_.
void Integrator::motion_from_increment(const State& s) {
  const double h = options_.step;
  system_.retract(s.q.data(), x_.data(), q_.data());
  const double i = 1 / (beta_ * h * h), c = (0.5 - beta_) / beta_;
  for (int k = 0; k < x_.size(); ++k) {
    algorithmic_[k] = i * (x_[k] - h * s.v[k]) - c * start_algorithmic_[k];
    v_[k] = s.v[k] + h * ((1 - gamma_) * start_algorithmic_[k] + gamma_ * algorithmic_[k]);
    a_[k] = ((1 - alpha_m_) * algorithmic_[k] + alpha_m_ * start_algorithmic_[k] - alpha_f_ * start_a_[k]) /
            (1 - alpha_f_);
  }
}

/// Adds to `target` the smallest change, in the norm of W, that brings Φz target to −violation; g_ is its
/// remainder.
void Integrator::project(double* target, const double* violation, double tolerance) {
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

StepStatus Integrator::step(State& s) {
  const int n = system_.velocities(), m = system_.equations();
  const double h = options_.step, time = s.time + h;
  const double scale = weights_.stiffness, penalty_factor = options_.penalty / scale;
  const double* alpha = system_.penalty();
  StepStatus status;

  system_.begin_step(s.q.data());
  start_a_ = s.a;
  start_algorithmic_ = s.algorithmic;
  if (!s.started) start(s);
  lambda_ = s.multipliers;
  const auto fail = [&](StepCode code) {
    status.code = code;
    return status;
  };

  // Predict constant true accelerations.
  for (int k = 0; k < n; ++k) {
    const double next = (start_a_[k] - alpha_m_ * start_algorithmic_[k]) / (1 - alpha_m_);
    x_[k] = h * s.v[k] + h * h * ((0.5 - beta_) * start_algorithmic_[k] + beta_ * next);
  }

  system_.temper_prediction(h, x_.data());

  double previous = 0, violation = 0;
  bool converged = false;
  bool refactor = true, settled = false, slow = false;
  mixing_.reset();
  for (int iteration = 0; iteration < options_.max_iterations; ++iteration) {
    motion_from_increment(s);
    system_.residual(time, q_.data(), v_.data(), a_.data(), lambda_.data(), 0, r_.data());
    ++status.iterations;
    violation = largest(system_.phi(), m);
    const double reference = std::max(9.81, largest(a_.data(), n));
    if (iteration == 0 && violation > 0.05 * largest(x_.data(), n)) {
      // The prediction tears the loops: velocities ring. Start from where the step starts instead.
      x_.setZero();
      continue;
    }
    const bool fresh = refactor || system_.tangent_changed(weights_);
    if (fresh) {
      mixing_.reset();
      const linalg::FactorStatus f = system_.factor(q_.data(), weights_);
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
    if (!settled)
      for (int k = 0; k < m; ++k) lambda_[k] += penalty_factor * alpha[k] * (system_.phi()[k] + impulse_[k]);
    int where = 0;
    status.correction = r_.cwiseAbs().maxCoeff(&where);
    status.coordinate = where;
    if (!std::isfinite(status.correction)) {
      status.coordinate = std::max(0, find_not_finite(r_.data(), n));
      return fail(StepCode::not_finite);
    }
    system_.compose(x_.data(), r_.data());
    if (slow) mixing_.mix(x_, lambda_, r_);

    // Error left: the last correction times the rate of contraction.
    const double rate = iteration == 0 ? 1.0 : status.correction / std::max(previous, 1e-300);
    previous = status.correction;
    const double left = status.correction * (rate < 0.5 ? rate / (1 - rate) : 1.0);
    converged = left <= options_.tolerance * scale * reference &&
                violation * std::min(1.0, rate) <= options_.position_tolerance;
    if (converged) break;
    // A new matrix where it helps; where even that contracts slowly, tangent terms are missing from it.
    slow = slow || (iteration > 1 && fresh && rate > 0.2);
    refactor = !slow && iteration > 0 && rate > 0.1;
  }
  if (!converged) return fail(StepCode::not_converged);
  motion_from_increment(s);

  // Velocities and accelerations onto the constraints.
  if (m > 0) {
    system_.kinematics(time, q_.data(), v_.data(), a_.data());
    status.position_violation = largest(system_.phi(), m);
    if (settled)
      for (int k = 0; k < m; ++k) lambda_[k] += penalty_factor * alpha[k] * system_.phi()[k];
    if (status.position_violation > 10 * options_.position_tolerance) return fail(StepCode::not_converged);
    algorithmic_ -= a_ * ((1 - alpha_f_) / (1 - alpha_m_));
    // The factorised matrix belongs to an earlier iterate, so that a projection leaves a little, which the
    // next removes.
    for (int round = 0; round < 5; ++round) {
      status.velocity_violation = largest(system_.phi_dot(), m);
      if (status.velocity_violation <= (round == 0 ? 1 : 1e2) * options_.velocity_tolerance) break;
      project(v_.data(), system_.phi_dot(), options_.velocity_tolerance);
      system_.kinematics(time, q_.data(), v_.data(), a_.data());
    }
    // The multipliers follow the accelerations, so that they balance the projected ones: M δ + Φzᵀ Δλ = 0.
    force_.setZero();
    project(a_.data(), system_.phi_ddot(), 1e-6);
    lambda_ += force_;
    algorithmic_ += a_ * ((1 - alpha_f_) / (1 - alpha_m_));
  } else {
    system_.kinematics(time, q_.data(), v_.data(), a_.data());
  }
  const int bad = find_not_finite(v_.data(), n);
  if (bad >= 0) {
    status.coordinate = bad;
    return fail(StepCode::not_finite);
  }
  s.time = time;
  s.q = q_;
  s.v = v_;
  s.a = a_;
  s.algorithmic = algorithmic_;
  s.multipliers = lambda_;
  s.started = true;
  return status;
}

}  // namespace mimbre
