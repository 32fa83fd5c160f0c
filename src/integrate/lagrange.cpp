#include "integrate/lagrange.h"

#include "integrate/drift.h"
#include "integrate/newton.h"
#include "integrate/stabilised.h"
#include "integrate/vectors.h"

namespace mimbre {

LagrangeStepper::LagrangeStepper(System& system, const IntegratorOptions& options, bool baumgarte)
    : Stepper(options),
      system_(system),
      motion_(system, options),
      dense_(system),
      stabilises_(baumgarte),
      mixing_(system.scales(), system.equations()) {
  set_step(options.step);
  for (Eigen::VectorXd* y : {&r_, &delta_}) y->setZero(system.velocities());
  for (Eigen::VectorXd* y : {&lambda_, &sigma_, &change_}) y->setZero(system.equations());
}

void LagrangeStepper::set_step(double step) {
  options_.step = step;
  motion_.set_step(step);
  weights_ = {motion_.rate * motion_.scale, motion_.scale, 0};
}

StepStatus LagrangeStepper::step(State& s) {
  const int n = system_.velocities();
  const double time = s.time + motion_.h;
  StepStatus status;
  const auto fail = [&](StepCode code) {
    status.code = code;
    return status;
  };
  const auto evaluate = [&] {
    motion_.from_increment(s);
    system_.residual(time, motion_.q.data(), motion_.v.data(), motion_.a.data(), lambda_.data(), 0,
                     r_.data());
  };

  frequency_ = stabilises_ ? options_.constraint_frequency * system_.scales().rate(s.v.data()) : 0;
  sigma_rate_ = stabilised_rate(motion_, options_.constraint_damping, frequency_);
  system_.begin_step(s.q.data());
  if (const StepCode code = motion_.begin(s, status); code != StepCode::ok) return fail(code);
  lambda_ = s.multipliers;
  system_.residual(s.time, s.q.data(), s.v.data(), motion_.start_a.data(), lambda_.data(), 0, r_.data());
  if (const int bad = find_not_finite(r_.data(), n); bad >= 0) {
    status.coordinate = bad;
    return fail(StepCode::not_finite);
  }
  dense_.assemble(s.q.data(), weights_);
  if (!dense_.choose(status)) return fail(StepCode::singular);

  motion_.predict(s);
  mixing_.reset();
  NewtonProgress newton;
  bool converged = false;
  for (int iteration = 0; iteration < options_.max_iterations && !converged; ++iteration) {
    const bool held = iteration == 0 && system_.hold_sticking(true);
    evaluate();
    if (held) system_.hold_sticking(false);
    ++status.iterations;
    if (const int bad = find_not_finite(r_.data(), n); bad >= 0) {
      status.coordinate = bad;
      return fail(StepCode::not_finite);
    }
    const bool fresh = newton.refactor || system_.tangent_changed(motion_.q.data(), weights_);
    if (fresh) {
      mixing_.reset();
      dense_.assemble(motion_.q.data(), weights_);
      if (!dense_.factor(status)) return fail(StepCode::singular);
    }
    stabilised(system_, options_.constraint_damping, frequency_, sigma_.data());
    double violation = 0;
    for (int k = 0; k < dense_.partition().rank(); ++k)
      violation = std::max(violation, std::abs(sigma_[dense_.partition().equation(k)]) /
                                          system_.scales().equations[dense_.partition().equation(k)]);
    r_ *= -motion_.scale;
    sigma_ /= -sigma_rate_;
    dense_.solve(r_.data(), sigma_.data(), delta_.data(), change_.data());
    lambda_ += change_ / motion_.scale;

    status.correction = system_.scales().of_coordinates(delta_.data(), &status.coordinate);
    if (const int bad = find_not_finite(delta_.data(), n); bad >= 0) {
      status.coordinate = bad;
      return fail(StepCode::not_finite);
    }
    const double enough = options_.tolerance * system_.scales().accelerations(motion_.a.data());
    system_.compose(motion_.x.data(), delta_.data());
    if (newton.slow) mixing_.mix(motion_.x, lambda_, delta_);
    const double left = newton.add(status.correction, fresh);
    converged = !held && left <= enough * motion_.scale && violation * std::min(1.0, newton.rate) <= enough;
  }
  if (!converged) return fail(StepCode::not_converged);
  evaluate();
  status.code = check_end(system_, motion_, options_.drift_limit, status);
  if (status.code != StepCode::ok) return status;
  // Whether a singular position was passed: there the motion could have changed to another branch.
  dense_.assemble(motion_.q.data(), weights_);
  if (!dense_.factor(status)) return fail(StepCode::singular);
  motion_.accept(s, lambda_);
  return status;
}

}  // namespace mimbre
