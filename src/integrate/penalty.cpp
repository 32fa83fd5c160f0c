#include "integrate/penalty.h"

#include "integrate/drift.h"
#include "integrate/newton.h"
#include "integrate/stabilised.h"
#include "integrate/vectors.h"

namespace mimbre {

/// Without multipliers the violation that is left is the constraint force over the penalty. It must not hide
/// which way a mechanism leaves a singular position, so that this penalty is the larger one.
constexpr double penalty_alone = 100;

PenaltyStepper::PenaltyStepper(System& system, const IntegratorOptions& options, bool augmented)
    : Stepper(options),
      system_(system),
      motion_(system, options),
      augmented_(augmented),
      penalty_(augmented ? options.penalty : penalty_alone * options.penalty),
      mixing_(system.scales(), system.equations()) {
  set_step(options.step);
  r_.setZero(system.velocities());
  for (Eigen::VectorXd* y : {&lambda_, &sigma_, &g_, &change_}) y->setZero(system.equations());
}

void PenaltyStepper::set_step(double step) {
  options_.step = step;
  motion_.set_step(step);
}

StepStatus PenaltyStepper::step(State& s) {
  const int n = system_.velocities(), m = system_.equations();
  const double time = s.time + motion_.h;
  const double* alpha = system_.penalty();
  StepStatus status;
  const auto fail = [&](StepCode code) {
    status.code = code;
    return status;
  };

  frequency_ = options_.constraint_frequency * system_.scales().rate(s.v.data());
  sigma_rate_ = stabilised_rate(motion_, options_.constraint_damping, frequency_);
  weights_ = {motion_.rate * motion_.scale, motion_.scale, penalty_ * sigma_rate_ * motion_.scale};
  system_.begin_step(s.q.data());
  if (const StepCode code = motion_.begin(s, status); code != StepCode::ok) return fail(code);
  motion_.predict(s);
  lambda_ = s.multipliers;
  mixing_.reset();
  NewtonProgress newton;
  bool converged = false, settled = false;
  for (int iteration = 0; iteration < options_.max_iterations && !converged; ++iteration) {
    motion_.from_increment(s);
    const bool held = iteration == 0 && system_.hold_sticking(true);
    system_.residual(time, motion_.q.data(), motion_.v.data(), motion_.a.data(), lambda_.data(), 0,
                     r_.data());
    if (held) system_.hold_sticking(false);
    ++status.iterations;
    if (iteration == 0 && system_.scales().of_equations(system_.phi()) >
                              0.05 * system_.scales().of_coordinates(motion_.x.data())) {
      motion_.x.setZero();
      continue;
    }
    const bool fresh = newton.refactor || system_.tangent_changed(motion_.q.data(), weights_);
    if (fresh) {
      mixing_.reset();
      const linalg::FactorStatus f = system_.factor(motion_.q.data(), weights_);
      ++status.factorisations;
      if (!f.ok()) {
        status.coordinate = f.unknown;
        return fail(find_not_finite(r_.data(), n) >= 0 ? StepCode::not_finite : StepCode::singular);
      }
    }
    // λ holds the constraint forces as they were known before this evaluation, so that what is added here
    // with the Jacobian of the factorised matrix vanishes in the end.
    stabilised(system_, options_.constraint_damping, frequency_, sigma_.data());
    for (int k = 0; k < m; ++k) g_[k] = penalty_ * alpha[k] * sigma_[k] - (augmented_ ? 0 : lambda_[k]);
    system_.add_jacobian_transposed(g_.data(), 1, r_.data());
    r_ *= -motion_.scale;
    system_.solve(r_.data());
    system_.jacobian_times(r_.data(), change_.data());
    const double reference = system_.scales().accelerations(motion_.a.data());
    const double violation = system_.scales().of_equations(sigma_.data()),
                 enough = options_.tolerance * reference;
    // Near singular positions multipliers would creep on along directions that hardly act.
    settled = augmented_ && iteration > 2 && violation <= enough;
    for (int k = 0; k < m; ++k) g_[k] += penalty_ * alpha[k] * sigma_rate_ * change_[k];
    if (!settled) lambda_ += g_;

    status.correction = system_.scales().of_coordinates(r_.data(), &status.coordinate);
    const int bad = find_not_finite(r_.data(), n);
    if (bad >= 0) {
      status.coordinate = bad;
      return fail(StepCode::not_finite);
    }
    system_.compose(motion_.x.data(), r_.data());
    if (newton.slow) mixing_.mix(motion_.x, lambda_, r_);
    const double left = newton.add(status.correction, fresh);
    converged = !held && left <= enough * motion_.scale &&
                (!augmented_ || violation * std::min(1.0, newton.rate) <= enough);
  }
  if (!converged) return fail(StepCode::not_converged);
  if (settled) lambda_ += g_;
  motion_.from_increment(s);
  system_.kinematics(time, motion_.q.data(), motion_.v.data(), motion_.a.data());
  status.code = check_end(system_, motion_, options_.drift_limit, status);
  if (status.code == StepCode::ok) motion_.accept(s, lambda_);
  return status;
}

}  // namespace mimbre
