#include "integrate/independent.h"

#include "integrate/drift.h"
#include "integrate/newton.h"
#include "integrate/vectors.h"

namespace mimbre {

IndependentStepper::IndependentStepper(System& system, const IntegratorOptions& options)
    : Stepper(options),
      system_(system),
      motion_(system, options),
      dense_(system),
      mixing_(system.scales(), system.equations()) {
  set_step(options.step);
  for (Eigen::VectorXd* y : {&r_, &delta_}) y->setZero(system.velocities());
  for (Eigen::VectorXd* y : {&none_, &change_, &violation_, &predicted_, &multipliers_})
    y->setZero(system.equations());
}

void IndependentStepper::set_step(double step) {
  options_.step = step;
  motion_.set_step(step);
  weights_ = {motion_.rate * motion_.scale, motion_.scale, 0};
}

/// Motion, matrices and r = M z̈ − Q at the increment as it is, with the dependent velocities and
/// accelerations that the constraints ask for there.
StepCode IndependentStepper::evaluate(const State& s, StepStatus& status) {
  const double time = s.time + motion_.h;
  const int n = system_.velocities(), m = system_.equations();
  Partition& partition = dense_.partition();
  motion_.from_increment(s);
  const auto residual = [&] {
    system_.residual(time, motion_.q.data(), motion_.v.data(), motion_.a.data(), none_.data(), 0, r_.data());
  };
  residual();
  if (const int bad = find_not_finite(r_.data(), n); bad >= 0) {
    status.coordinate = bad;
    return StepCode::not_finite;
  }
  dense_.assemble(motion_.q.data(), weights_);
  if (!dense_.factor(status)) return StepCode::singular;
  if (m == 0) return StepCode::ok;
  std::copy_n(system_.phi(), m, predicted_.data());
  const auto follow = [&](Eigen::VectorXd& target, const double* violation) {
    for (int k = 0; k < m; ++k) change_[k] = -violation[k];
    partition.particular(change_.data(), delta_.data());
    target += delta_;
  };
  follow(motion_.v, system_.phi_dot());
  system_.kinematics(time, motion_.q.data(), motion_.v.data(), motion_.a.data());
  follow(motion_.a, system_.phi_ddot());
  residual();
  return StepCode::ok;
}

StepStatus IndependentStepper::step(State& s) {
  const int n = system_.velocities(), m = system_.equations();
  StepStatus status;
  const auto fail = [&](StepCode code) {
    status.code = code;
    return status;
  };

  system_.begin_step(s.q.data());
  if (const StepCode code = motion_.begin(s, status); code != StepCode::ok) return fail(code);
  system_.residual(s.time, s.q.data(), s.v.data(), motion_.start_a.data(), none_.data(), 0, r_.data());
  if (const int bad = find_not_finite(r_.data(), n); bad >= 0) {
    status.coordinate = bad;
    return fail(StepCode::not_finite);
  }
  dense_.assemble(s.q.data(), weights_);
  if (!dense_.choose(status)) return fail(StepCode::singular);
  const Partition& partition = dense_.partition();
  const std::vector<char>& is_rate = system_.scales().is_rate;

  motion_.predict(s);
  mixing_.reset();
  NewtonProgress newton;
  bool converged = false;
  for (int iteration = 0; iteration < options_.max_iterations && !converged; ++iteration) {
    ++status.iterations;
    const bool held = iteration == 0 && system_.hold_sticking(true);
    const StepCode code = evaluate(s, status);
    if (held) system_.hold_sticking(false);
    if (code != StepCode::ok) return fail(code);
    for (int k = 0; k < m; ++k) violation_[k] = -system_.phi()[k];
    // Of velocities alone: that of the velocities that the increment makes.
    for (std::size_t k = 0; k < is_rate.size(); ++k)
      if (is_rate[k]) violation_[static_cast<Eigen::Index>(k)] = -predicted_[static_cast<Eigen::Index>(k)];
    double violation = 0;
    for (int k = 0; k < partition.rank(); ++k)
      violation = std::max(violation, std::abs(violation_[partition.equation(k)]) /
                                          system_.scales().equations[partition.equation(k)]);
    r_ *= -motion_.scale;
    dense_.solve(r_.data(), violation_.data(), delta_.data(), change_.data());
    status.correction = system_.scales().of_coordinates(delta_.data(), &status.coordinate);
    if (const int bad = find_not_finite(delta_.data(), n); bad >= 0) {
      status.coordinate = bad;
      return fail(StepCode::not_finite);
    }
    system_.compose(motion_.x.data(), delta_.data());
    if (newton.slow) mixing_.mix(motion_.x, none_, delta_);
    const double left = newton.add(status.correction, true);
    converged =
        !held &&
        left <= options_.tolerance * motion_.scale * system_.scales().accelerations(motion_.a.data()) &&
        violation * std::min(1.0, newton.rate) <= options_.position_tolerance;
  }
  if (!converged) return fail(StepCode::not_converged);
  if (const StepCode code = evaluate(s, status); code != StepCode::ok) return fail(code);
  // Equations that were set aside as redundant must hold as well.
  status.code =
      check_end(system_, motion_, std::min(options_.drift_limit, 1e3 * options_.position_tolerance), status);
  if (status.code != StepCode::ok) return status;

  // What the rule carries over for dependent coordinates belongs to their own accelerations, so that any of
  // them may be independent in the next step.
  const RuleCoefficients& c = motion_.rule;
  for (int k = 0; k < partition.rank(); ++k) {
    const int d = partition.dependent(k);
    motion_.algorithmic[d] = ((1 - c.alpha_f) * motion_.a[d] + c.alpha_f * motion_.start_a[d] -
                              c.alpha_m * motion_.start_algorithmic[d]) /
                             (1 - c.alpha_m);
  }
  r_ = -r_;
  dense_.partition().multipliers(r_.data(), multipliers_.data());
  motion_.accept(s, multipliers_);
  return status;
}

}  // namespace mimbre
