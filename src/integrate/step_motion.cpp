#include "integrate/step_motion.h"

#include "integrate/vectors.h"

namespace mimbre {

/// Accelerations of the start that a round changes by no more than this part of themselves are known.
constexpr double settled = 1e-8;
/// Rounds of the start without and with loads of inertia; the latter are mixed once one leaves more than this
/// share of the correction before it.
constexpr int plain_rounds = 8, loaded_rounds = 40;
constexpr double slow_rounds = 0.2;
/// Rounds after them, where what sticks at rest breaks away in the step.
constexpr int broken_rounds = 12;
/// Nonlinear, they go on until a round changes no more than this part: that of a step's iterations.
constexpr double settled_broken = 1e-5;

StepMotion::StepMotion(System& of, const IntegratorOptions& options)
    : system(of), rule(rule_coefficients(options)), penalty(options.penalty), driven(of) {
  set_step(options.step);
  const int n = system.velocities();
  q.setZero(system.positions());
  for (Eigen::VectorXd* y : {&x, &v, &a, &algorithmic, &start_a, &start_algorithmic, &r_}) y->setZero(n);
  for (Eigen::VectorXd* y : {&g_, &change_, &start_multipliers_, &stuck_multipliers_})
    y->setZero(system.equations());
  if (system.has_loads_of_inertia()) {
    along_.setZero(system.equations() + system.velocities());
    mixing_.emplace(system.scales(), static_cast<int>(along_.size()));
  }
}

void StepMotion::set_step(double step) {
  h = step;
  scale = (1 - rule.alpha_f) / (1 - rule.alpha_m) * rule.beta * step * step;
  rate = rule.gamma / (rule.beta * step);
  system.set_rate_time(1 / rate);
}

StepCode StepMotion::begin(const State& s, StepStatus& status) {
  start_a = s.a;
  start_algorithmic = s.algorithmic;
  return s.started ? StepCode::ok : start(s, status);
}

/// Accelerations W a + Φzᵀ λ = Q, Φ̈ = 0 with W = M + γhC + βh²K instead of M. Where the start is not in
/// balance, stiff modes would start with accelerations that no step of this length can follow and that
/// overshoot by far; W bounds them by what the step can bring about, and changes those of slow motions by
/// terms of the order of the step. Loads of inertia in Q go by the accelerations: each round takes them at
/// those of the round before. In a body that is far bent that alone diverges.
StepCode StepMotion::start(const State& s, StepStatus& status) {
  const int n = system.velocities(), m = system.equations();
  const double* alpha = system.penalty();
  const bool loads = mixing_.has_value();  // x has them as of the round
  bool slow = false;
  double before = 0;
  if (loads) mixing_->reset();
  a.setZero();
  g_.setZero();
  start_multipliers_.setZero();
  for (int round = 0; round < (loads ? loaded_rounds : plain_rounds); ++round) {
    // r = Q − M a: only the first round's, W a is followed by hand through the corrections.
    if (round == 0) {
      // Of what remembers, forces are those at this instant, and the tangents those of a step.
      const bool remembers = s.z.size() > 0;
      if (remembers) system.enter(s.u.data(), s.z.data(), 0);
      system.residual(s.time, s.q.data(), s.v.data(), a.data(), g_.data(), 0, r_.data());
      if (remembers) {
        system.enter(s.u.data(), s.z.data(), h);
        system.residual(s.time, s.q.data(), s.v.data(), a.data(), g_.data(), 0, x.data());
      }
      const linalg::FactorStatus f = system.factor(s.q.data(), {rate * scale, scale, penalty});
      if (const int bad = find_not_finite(r_.data(), n); bad >= 0) {
        status.coordinate = bad;
        return StepCode::not_finite;
      }
      if (!f.ok()) {
        status.coordinate = f.unknown;
        return StepCode::singular;
      }
      x.setZero();
      if (loads) system.add_loads_of_inertia(s.q.data(), a.data(), x.data());
    } else {
      system.kinematics(s.time, s.q.data(), s.v.data(), a.data());
      r_.setZero();
      if (loads) {  // what has changed of them since the last round
        r_ -= x;
        x.setZero();
        system.add_loads_of_inertia(s.q.data(), a.data(), x.data());
        r_ += x;
      }
    }
    for (int k = 0; k < m; ++k) g_[k] = penalty * alpha[k] * system.phi_ddot()[k];
    system.add_jacobian_transposed(g_.data(), 1, r_.data());
    for (int k = 0; k < n; ++k) r_[k] = -r_[k];
    system.solve(r_.data());
    if (const int bad = find_not_finite(r_.data(), n); bad >= 0) {
      status.coordinate = bad;
      return StepCode::not_finite;
    }
    a += r_;
    system.jacobian_times(r_.data(), change_.data());
    for (int k = 0; k < m; ++k) start_multipliers_[k] += g_[k] + penalty * alpha[k] * change_[k];
    const Scales& scales = system.scales();
    const double correction = scales.of_coordinates(r_.data());
    if ((m == 0 && !loads) || correction <= settled * scales.accelerations(a.data())) break;
    slow = slow || (loads && round > 0 && correction > slow_rounds * before);
    before = correction;
    if (!slow) continue;
    along_ << start_multipliers_, x;
    mixing_->mix(a, along_, r_);
    start_multipliers_ = along_.head(m);
    x = along_.tail(n);
  }
  if (const StepCode code = break_away(s, status); code != StepCode::ok) return code;
  driven.accelerate(s.time, s.q.data(), s.v.data(), start_multipliers_.data(), a.data());
  start_a = start_algorithmic = a;
  return StepCode::ok;
}

/// W has the tangents of the start, of friction at rest the stiffness of what sticks. Where such a stiffness
/// falls within βh² a and γh a, that is where something breaks away, accelerations are those that balance the
/// forces there, M a + Φzᵀ λ = Q(q ⊕ (h v + βh² a), v + γh a), by Newton: else half a step's acceleration
/// would be lost. What slides already must go on there, hence h v. Where Newton does not settle, those by W
/// stay.
StepCode StepMotion::break_away(const State& s, StepStatus& status) {
  const int n = system.velocities(), m = system.equations();
  const MatrixWeights weights{rate * scale, scale, penalty};
  const double* alpha = system.penalty();
  const Scales& scales = system.scales();
  const auto move = [&](double along) {
    x = scale * a;
    v = s.v + rate * x;
    x += along * s.v;
    system.retract(s.q.data(), x.data(), q.data());
    system.residual(s.time, q.data(), v.data(), a.data(), start_multipliers_.data(), 0, r_.data());
  };
  move(0);
  if (!system.tangent_fell(weights)) return StepCode::ok;
  algorithmic = a;
  stuck_multipliers_ = start_multipliers_;
  for (int round = 0; round < broken_rounds; ++round) {
    move(h);
    if (system.tangent_changed(q.data(), weights) && !system.factor(q.data(), weights).ok()) break;
    system.kinematics(s.time, s.q.data(), s.v.data(), a.data());
    for (int k = 0; k < m; ++k) g_[k] = penalty * alpha[k] * system.phi_ddot()[k];
    system.add_jacobian_transposed(g_.data(), 1, r_.data());
    for (int k = 0; k < n; ++k) r_[k] = -r_[k];
    system.solve(r_.data());
    if (find_not_finite(r_.data(), n) >= 0) break;
    a += r_;
    system.jacobian_times(r_.data(), change_.data());
    for (int k = 0; k < m; ++k) start_multipliers_[k] += g_[k] + penalty * alpha[k] * change_[k];
    if (scales.of_coordinates(r_.data()) <= settled_broken * scales.accelerations(a.data()))
      return StepCode::ok;
  }
  a = algorithmic;
  start_multipliers_ = stuck_multipliers_;
  // The tangents again that belong to these.
  system.residual(s.time, s.q.data(), s.v.data(), a.data(), start_multipliers_.data(), 0, r_.data());
  const linalg::FactorStatus f = system.factor(s.q.data(), weights);
  status.coordinate = f.unknown;
  return f.ok() ? StepCode::ok : StepCode::singular;
}

void StepMotion::predict(const State& s) {
  for (int k = 0; k < x.size(); ++k) {
    const double next = (start_a[k] - rule.alpha_m * start_algorithmic[k]) / (1 - rule.alpha_m);
    x[k] = h * s.v[k] + h * h * ((0.5 - rule.beta) * start_algorithmic[k] + rule.beta * next);
  }
  system.temper_prediction(h, x.data());
}

void StepMotion::predict_velocities(const State& s) {
  for (int k = 0; k < x.size(); ++k) x[k] = h * s.v[k];
}

void StepMotion::from_increment(const State& s) {
  system.retract(s.q.data(), x.data(), q.data());
  const double i = 1 / (rule.beta * h * h), c = (0.5 - rule.beta) / rule.beta;
  for (int k = 0; k < x.size(); ++k) {
    algorithmic[k] = i * (x[k] - h * s.v[k]) - c * start_algorithmic[k];
    v[k] = s.v[k] + h * ((1 - rule.gamma) * start_algorithmic[k] + rule.gamma * algorithmic[k]);
    a[k] = ((1 - rule.alpha_m) * algorithmic[k] + rule.alpha_m * start_algorithmic[k] -
            rule.alpha_f * start_a[k]) /
           (1 - rule.alpha_f);
  }
}

void StepMotion::begun(State& s) const {
  s.a = start_a;
  s.multipliers = start_multipliers_;
}

void StepMotion::accept(State& s, const Eigen::VectorXd& multipliers) const {
  s.time += h;
  s.q = q;
  s.v = v;
  s.a = a;
  s.algorithmic = algorithmic;
  s.multipliers = multipliers;
  s.started = true;
}

}  // namespace mimbre
