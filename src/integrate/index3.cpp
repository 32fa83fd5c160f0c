#include "integrate/index3.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "integrate/newton.h"
#include "integrate/step_end.h"
#include "integrate/vectors.h"

namespace mimbre {
namespace {

// Of corrections that do not get smaller: round-off in directions that are hardly determined.
constexpr double least_noise = 1e-11, noise_by_round_off = 1e4;
constexpr int most_idle = 4;
// An iteration goes on to this share of its first correction.
constexpr double share_of_prediction = 3e-5;
// Near singular positions: when the projection changes velocities by much more than they violate the
// constraints, and by that share of themselves; then with a penalty that much larger down to that violation.
constexpr double singular_amplification = 100, singular_change = 1e-5;
// Of a fixed cost: corrections by more than this part of the mechanism's size lead nowhere.
constexpr double absurd_correction = 0.1;
constexpr double precise_penalty = 1e4, precise_violation = 1e-13;

}  // namespace

IndexThree::IndexThree(System& system, const IntegratorOptions& options)
    : Stepper(options),
      system_(system),
      scales_(system.scales()),
      motion_(system, options),
      mixing_(system.velocities(), system.equations()) {
  set_step(options.step);
  const int n = system.velocities(), m = system.equations();
  r_.setZero(n);
  unprojected_.setZero(n);
  for (Eigen::VectorXd* x : {&lambda_, &impulse_, &g_, &force_, &rates_}) x->setZero(m);
  if (options.fixed_cost) {
    nearest_.x.setZero(n);
    nearest_.lambda.setZero(m);
    before_.setZero(m);
  }
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
  for (int round = 0; round < 6 && scales_.of_equations(g_.data()) > tolerance; ++round) {
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
  bool near_singular = false;
  StepStatus status = attempt(s, false, near_singular);
  if (options_.fixed_cost || system_.equations() == 0 ||
      (!near_singular && status.code != StepCode::not_converged))
    return status;
  // Where the constraints hardly determine a direction, what is left of them decides on it, and on the branch
  // that the mechanism takes.
  const StepStatus first = status;
  status = attempt(s, true, near_singular);
  status.iterations += first.iterations;
  status.factorisations += first.factorisations;
  return status;
}

StepStatus IndexThree::attempt(State& s, bool precise, bool& near_singular) {
  const int n = system_.velocities(), m = system_.equations();
  const double time = s.time + motion_.h;
  const double penalty = options_.penalty * (precise ? precise_penalty : 1);
  weights_.penalty = penalty;
  const double scale = motion_.scale, penalty_factor = penalty / scale;
  const double position_tolerance =
      precise ? std::max(precise_violation, scales_.round_off) : options_.position_tolerance;
  const double* alpha = system_.penalty();
  Eigen::VectorXd &x = motion_.x, &v = motion_.v, &a = motion_.a;
  const Eigen::VectorXd& q = motion_.q;
  StepStatus status;

  system_.begin_step(s.q.data());
  lambda_ = s.multipliers;
  const auto fail = [&](StepCode code) {
    status.code = code;
    return status;
  };
  if (const StepCode code = motion_.begin(s, status); code != StepCode::ok) return fail(code);
  motion_.predict(s);

  double violation = 0, reference = 0, predicted = 0, before = 0, enough_velocity = 0;
  bool foreseen = false;
  bool converged = false, settled = false;
  NewtonProgress newton;
  mixing_.reset();
  nearest_.off = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < options_.max_iterations; ++iteration) {
    motion_.from_increment(s);
    system_.residual(time, q.data(), v.data(), a.data(), lambda_.data(), 0, r_.data());
    ++status.iterations;
    violation = scales_.of_equations(system_.phi());
    reference = scales_.accelerations(a.data());
    if (iteration == 0 && violation > 0.05 * scales_.of_coordinates(x.data())) {
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
    const bool last = options_.fixed_cost && iteration + 1 == options_.max_iterations;
    const bool fresh = precise || newton.refactor || system_.tangent_changed(q.data(), weights_);
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
    settled = !precise && iteration > 2 && violation <= position_tolerance;
    if (options_.fixed_cost) before_ = lambda_;
    for (int k = 0; k < m; ++k) force_[k] = penalty_factor * alpha[k] * (system_.phi()[k] + impulse_[k]);
    if (!settled) lambda_ += force_;
    status.correction = scales_.of_coordinates(r_.data(), &status.coordinate);
    // What a correction is measured from is known to be that far off; of what is absurd the prediction is
    // kept.
    if (options_.fixed_cost &&
        (newton.corrections == 0 || status.correction < std::min(nearest_.off, absurd_correction))) {
      nearest_.off = status.correction;
      nearest_.x = x;
      nearest_.lambda = before_;
    }
    if (const int bad = find_not_finite(r_.data(), n); bad >= 0) {
      status.coordinate = bad;
      return fail(StepCode::not_finite);
    }
    system_.compose(x.data(), r_.data());
    if (newton.slow) mixing_.mix(x, lambda_, r_);

    const double left = newton.add(status.correction, fresh);
    if (newton.corrections == 1) predicted = status.correction;
    // In a short step the tolerance alone would allow errors that add up to more than those of the rule: what
    // the prediction is off by falls with the step as they do. And positions are known to round-off only, of
    // which directions that the constraints hardly determine take a multiple: there corrections stop getting
    // smaller.
    const bool stagnant = newton.idle >= most_idle && violation <= scales_.round_off;
    const double asked = options_.tolerance * scale * reference;
    const double enough = stagnant ? std::max({asked, least_noise, noise_by_round_off * scales_.round_off})
                                   : std::min(asked, share_of_prediction * predicted);
    converged = left <= std::max(enough, std::numeric_limits<double>::epsilon()) &&
                violation * std::min(1.0, newton.rate) <= position_tolerance;
    if (converged || last) {
      // Where iterations went away from the solution, the iterate that was nearest to it.
      const bool back = !converged && status.correction > std::min(nearest_.off, absurd_correction);
      if (back) {
        x = nearest_.x;
        lambda_ = nearest_.lambda;
        settled = false;
      }
      motion_.from_increment(s);
      // Not the penalty's force of the violation that is left, which is round-off times a large number.
      if (settled) lambda_ += force_;
      enough_velocity = options_.velocity_tolerance * scales_.rate(v.data());
      unprojected_ = v;
      // What the last correction, which is small, makes of the rates is known before they are evaluated.
      foreseen = m > 0 && !precise && !newton.slow && !back;
      if (foreseen) {
        for (int k = 0; k < m; ++k) rates_[k] = system_.phi_dot()[k] + motion_.rate * impulse_[k];
        before = scales_.of_equations(rates_.data());
        foreseen = before > enough_velocity;
        if (foreseen) project(v.data(), rates_.data(), enough_velocity);
      }
      system_.kinematics(time, q.data(), v.data(), a.data());
      scales_.of_kinds(system_.phi(), status.position_violation, status.angle_violation);
      if (scales_.of_equations(system_.phi()) <= 10 * position_tolerance) break;
      // The rate promised too much.
      converged = false;
      if (last) break;
      newton.refactor = !newton.slow;
    }
  }
  if (!converged && !options_.fixed_cost) return fail(StepCode::not_converged);
  status.unconverged = !converged;
  // What is taken as it is must still be a position of the mechanism.
  if (!converged)
    if (const StepCode code = check_end(system_, motion_, options_.drift_limit, status); code != StepCode::ok)
      return fail(code);

  // Velocities and accelerations onto the constraints.
  if (m > 0) {
    motion_.algorithmic -= a * ((1 - motion_.rule.alpha_f) / (1 - motion_.rule.alpha_m));
    // The factorised matrix belongs to an earlier iterate, so that a projection leaves a little, which the
    // next removes.
    const double enough = enough_velocity;
    if (!foreseen) before = scales_.of_equations(system_.phi_dot());
    for (int round = 0; round < 5; ++round) {
      if (scales_.of_equations(system_.phi_dot()) <= (round == 0 && !precise && !foreseen ? 1 : 1e2) * enough)
        break;
      project(v.data(), system_.phi_dot(), enough);
      system_.kinematics(time, q.data(), v.data(), a.data());
    }
    unprojected_ -= v;

    const double change = scales_.of_coordinates(unprojected_.data());
    // Never accepted, but for a fixed cost: velocities that violate the constraints.
    const bool held = scales_.of_equations(system_.phi_dot()) <= 1e2 * enough;
    near_singular = !held || (change > singular_amplification * before &&
                              change > singular_change * scales_.of_coordinates(v.data()));
    if (options_.fixed_cost && near_singular) {
      status.unconverged = true;
      // A projection that goes astray is worse than none.
      v += unprojected_;
      system_.kinematics(time, q.data(), v.data(), a.data());
    } else if (near_singular && !precise) {
      return status;
    } else if (!held) {
      return fail(StepCode::not_converged);
    }
    scales_.of_kinds(system_.phi_dot(), status.velocity_violation, status.angular_velocity_violation);
    // The multipliers follow the accelerations, so that they balance the projected ones: M δ + Φzᵀ Δλ = 0.
    // Near singular positions this would amplify what is left of the velocities' error.
    if (!precise && !near_singular) {
      force_.setZero();
      project(a.data(), system_.phi_ddot(), options_.acceleration_tolerance * reference);
      lambda_ += force_;
    }
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
