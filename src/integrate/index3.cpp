#include "integrate/index3.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "integrate/vectors.h"

namespace mimbre {
namespace {

// A prediction that violates the constraints by more than this share of its length separates the loops.
constexpr double separating_prediction = 0.05;
// After this many iterations the multipliers stay once the constraints are satisfied.
constexpr int iterations_before_settling = 3;
// Velocities are accepted with violations of up to this multiple of their tolerance.
constexpr double accepted_velocities = 100;
// Projections of one vector with one matrix, and evaluations of the velocities with their projection.
constexpr int most_projections = 6, most_velocity_rounds = 5;
// Near singular positions the projection changes velocities by this multiple of their violation, and by this
// share of themselves. The step is then repeated with a larger penalty down to a smaller violation.
constexpr double singular_amplification = 100, singular_change = 1e-5;
constexpr double precise_penalty = 1e4, precise_violation = 1e-13;
// Parts of a step below this share of it leave violations as they find them, and correct none of the size of
// round-off. Forces that corrected these would go by the square of the part, and redundant constraints would
// keep them.
constexpr double short_part = 1e-3;
// Steps at most that a matrix leads through with equations, and what they may project away, as shares of
// velocities and accelerations, less the more steps it has led through.
constexpr int most_uses = 5;
constexpr double projected_velocities = 1e-7, projected_accelerations = 1e-5;
// Steps at most before a matrix is kept again.
constexpr int longest_pause = 15;
// How far a correction may be followed is searched after this many of them (line_search.cpp).
constexpr int search_from = 8;
// An iteration that fails after a correction of this size fails because it diverges.
constexpr double lost_correction = 1;

/// 0 of nothing, infinite of something to nothing.
double ratio(double part, double of) { return part > 0 ? part / of : 0; }

}  // namespace

IndexThree::IndexThree(System& system, const IntegratorOptions& options)
    : Stepper(options),
      system_(system),
      scales_(system.scales()),
      usual_step_(options.step),
      motion_(system, options),
      prediction_(system.velocities()),
      keeps_(!options.fixed_cost && system.keeps_matrix() &&
             (system.equations() == 0 || motion_.rule.gamma > 0.5)),
      searches_(!options.fixed_cost && system.hold_sticking(false)),
      mixing_(system.scales(), system.equations()) {
  set_step(options.step);
  const int n = system.velocities(), m = system.equations();
  r_.setZero(n);
  unprojected_.setZero(n);
  for (Eigen::VectorXd* x : {&lambda_, &impulse_, &g_, &force_, &rates_, &inherited_, &own_}) x->setZero(m);
  for (Eigen::VectorXd* x : {&line_, &line_x_}) x->setZero(n);
  line_lambda_.setZero(m);
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
  for (int round = 0; round < most_projections && scales_.of_equations(g_.data()) > tolerance; ++round) {
    r_.setZero();
    if (!system_.solve_with_constraint_forces(1, weights_.penalty, g_.data(), r_.data(), impulse_.data())) {
      for (int k = 0; k < m; ++k) impulse_[k] = alpha[k] * g_[k];
      system_.add_jacobian_transposed(impulse_.data(), -weights_.penalty, r_.data());
      system_.solve(r_.data());
      system_.jacobian_times(r_.data(), impulse_.data());
    }
    for (int k = 0; k < n; ++k) target[k] += r_[k];
    for (int k = 0; k < m; ++k) {
      g_[k] += impulse_[k];
      force_[k] += weights_.penalty * alpha[k] * g_[k];
    }
  }
}

StepStatus IndexThree::step(State& s) {
  const Attempt first = attempt(s, false);
  if (options_.fixed_cost || system_.equations() == 0 ||
      (!first.near_singular && first.status.code != StepCode::not_converged))
    return first.status;
  // Where the constraints hardly determine a direction, their residual decides on the motion along it, and on
  // the branch that the mechanism takes.
  StepStatus status = attempt(s, true).status;
  status.iterations += first.status.iterations;
  status.factorisations += first.status.factorisations;
  return status;
}

IndexThree::Attempt IndexThree::attempt(State& s, bool precise) {
  Attempt t = begin(s, precise);
  if (t.status.code != StepCode::ok) return t;
  for (int iteration = 0; iteration < options_.max_iterations; ++iteration) {
    const bool last = options_.fixed_cost && iteration + 1 == options_.max_iterations;
    t.held = t.predicted && system_.hold_sticking(true);
    evaluate(s, t);
    if (t.held) system_.hold_sticking(false);
    if (std::exchange(t.predicted, false) && replace_prediction(s, t)) continue;
    if (!find_correction(t)) return t;
    update_multipliers(t, iteration);
    if (options_.fixed_cost) keep_nearest(t);
    if (!apply_correction(s, t)) return t;
    decide_convergence(t);
    if (t.lost) {
      begin_again(s, t);
      continue;
    }
    if (!t.converged && !last) continue;
    end_positions(s, t);
    if (last || t.converged) break;
    t.newton.refactor = !t.newton.slow;
  }
  if (!accept_positions(t)) return t;
  if (system_.equations() > 0) {
    project_velocities(t);
    const bool repeat = t.near_singular && !options_.fixed_cost && !precise;
    if (repeat || t.status.code != StepCode::ok) return t;
    project_accelerations(t);
  } else {
    unprojected_ = motion_.a;
  }
  if (const int bad = find_not_finite(motion_.v.data(), system_.velocities()); bad >= 0) {
    t.status.coordinate = bad;
    t.status.code = StepCode::not_finite;
    return t;
  }
  if (keeps_) judge_matrix(t);
  motion_.accept(s, lambda_);
  prediction_.learn(motion_.h, scales_, motion_.x);
  return t;
}

IndexThree::Attempt IndexThree::begin(State& s, bool precise) {
  Attempt t;
  t.precise = precise;
  t.time = s.time + motion_.h;
  weights_.penalty = options_.penalty * (precise ? precise_penalty : 1);
  t.by_kept = kept_ && s.started && weights_ == kept_weights_ && system_.matrices() == kept_matrix_;
  t.newton.refactor = !t.by_kept;
  kept_ = false;
  t.position_tolerance =
      precise ? std::max(precise_violation, scales_.round_off) : options_.position_tolerance;
  system_.begin_step(s.q.data());
  nearest_.off = std::numeric_limits<double>::infinity();
  if (!s.started) prediction_.forget();
  t.status.code = motion_.begin(s, t.status);
  if (t.status.code != StepCode::ok) return t;
  predict(s, t);
  if (!precise && motion_.h < short_part * usual_step_ && system_.equations() > 0) {
    system_.kinematics(s.time, s.q.data(), s.v.data(), s.a.data());
    t.inherits = scales_.of_equations(system_.phi()) <= accepted_positions * t.position_tolerance;
    std::copy_n(system_.phi(), system_.equations(), inherited_.data());
  }
  return t;
}

/// Whether the matrix leads through the next step too: as long as it contracts well and does not cost more
/// corrections than when it was new. With equations velocities and accelerations are projected by it, with an
/// old one along directions that are wrong by its age: it may be as old as a few steps, while what is
/// projected away hardly counts. Over a motion by the mechanism's length that adds up to its share times the
/// age.
void IndexThree::judge_matrix(const Attempt& t) {
  const bool fresh = t.status.factorisations > 0;
  if (t.by_kept && fresh) pause_keeping();
  if (t.by_kept && !fresh) pause_ = 0;
  if (fresh) kept_corrections_ = t.newton.corrections;
  uses_ = t.assembled ? 1 : uses_ + 1;
  const bool young = system_.equations() == 0 || (uses_ < most_uses && uses_ * t.projected_away <= 1);
  kept_ = young && waits_ == 0 && !t.newton.refactor && !t.newton.slow &&
          t.newton.corrections <= kept_corrections_;
  if (waits_ > 0) --waits_;
  kept_weights_ = weights_;
  kept_matrix_ = system_.matrices();
}

void IndexThree::pause_keeping() {
  pause_ = std::min(2 * pause_ + 1, longest_pause);
  waits_ = pause_;
}

void IndexThree::transfer_matrix(StateTransfer& transfer) {
  if (!keeps_) return;
  // Where another matrix has been made since, there is none to go on with.
  bool kept = kept_ && kept_matrix_ == system_.matrices();
  transfer(kept, kept_corrections_, uses_, pause_, waits_, kept_weights_.damping, kept_weights_.stiffness,
           kept_weights_.penalty);
  system_.transfer_matrix(transfer);
  if (!transfer.restoring()) return;
  kept_ = kept;
  kept_matrix_ = system_.matrices();
}

/// Where the iterations begin.
void IndexThree::predict(const State& s, Attempt& t) {
  lambda_ = s.multipliers;
  mixing_.reset();
  motion_.predict(s);
  prediction_.begin(motion_.h, motion_.x);
  t.predicted = true;
}

/// The matrix of an earlier step has led astray: with one of the step's own.
void IndexThree::begin_again(const State& s, Attempt& t) {
  predict(s, t);
  t.newton = {};
  t.by_kept = t.lost = false;
  pause_keeping();
}

/// The residual of the equations of motion, into r_, and the violation, at the iterate.
void IndexThree::evaluate(const State& s, Attempt& t) {
  motion_.from_increment(s);
  system_.residual(t.time, motion_.q.data(), motion_.v.data(), motion_.a.data(), lambda_.data(), 0,
                   r_.data());
  ++t.status.iterations;
  if (t.inherits) leave_inherited();
  t.violation = scales_.of_equations(violation(t));
  t.accelerations = scales_.accelerations(motion_.a.data());
}

/// own_: Φ without what the step before left, and without round-off.
void IndexThree::leave_inherited() {
  for (int k = 0; k < system_.equations(); ++k) {
    const double own = system_.phi()[k] - inherited_[k];
    const bool counts = std::abs(own) > scales_.round_off * scales_.equations[static_cast<std::size_t>(k)];
    own_[k] = counts ? own : 0;
  }
}

const double* IndexThree::violation(const Attempt& t) const {
  return t.inherits ? own_.data() : system_.phi();
}

/// Whether the prediction was replaced by one that does not lead to another solution or excite velocities.
bool IndexThree::replace_prediction(const State& s, const Attempt& t) {
  if (t.violation > separating_prediction * scales_.of_coordinates(motion_.x.data())) {
    // The velocities would oscillate. Begin at the start of the step instead.
    motion_.x.setZero();
    prediction_.replace(motion_.x);
    return true;
  }
  if (options_.rule == IntegratorOptions::Rule::newmark &&
      system_.tangent_changed(motion_.q.data(), weights_)) {
    // An impact begins or ends: Newmark's accelerations oscillate there and, extrapolated, can lead to
    // another, wrong solution of the step.
    motion_.predict_velocities(s);
    prediction_.replace(motion_.x);
    return true;
  }
  return false;
}

/// False, for the phases: the iteration ends at this coordinate.
bool IndexThree::fail(Attempt& t, StepCode code, int coordinate) {
  const bool lost = t.newton.corrections > 0 && t.newton.previous > lost_correction;
  t.status.code = lost ? StepCode::not_converged : code;
  t.status.coordinate = coordinate;
  return false;
}

/// δ, into r_: f δ = −βh² (M z̈ + Φzᵀ λ − Q + Φzᵀ α Φ), of which r_ has all but the last. The penalty's force
/// has the Jacobian of the factorised matrix, so that an old matrix still leads to Φ = 0. impulse_: Φz δ.
void IndexThree::solve_for_correction(const double* phi) {
  const int n = system_.velocities(), m = system_.equations();
  if (system_.solve_with_constraint_forces(motion_.scale, weights_.penalty, phi, r_.data(), impulse_.data()))
    return;
  const double penalty_factor = weights_.penalty / motion_.scale;
  const double* alpha = system_.penalty();
  for (int k = 0; k < m; ++k) impulse_[k] = penalty_factor * alpha[k] * phi[k];
  system_.add_jacobian_transposed(impulse_.data(), 1, r_.data());
  for (int k = 0; k < n; ++k) r_[k] *= -motion_.scale;
  system_.solve(r_.data());
  system_.jacobian_times(r_.data(), impulse_.data());
}

/// With a new matrix where one is needed.
bool IndexThree::find_correction(Attempt& t) {
  const int n = system_.velocities();
  t.refactored = t.precise || t.newton.refactor;
  t.assembled = t.assembled || t.refactored;
  if (t.refactored || system_.tangent_changed(motion_.q.data(), weights_)) {
    // With a new matrix in every iteration corrections depend on the iterate alone, and may be mixed.
    if (!t.precise) mixing_.reset();
    const linalg::FactorStatus f = t.refactored ? system_.factor(motion_.q.data(), weights_)
                                                : system_.factor_tangents(motion_.q.data(), weights_);
    ++t.status.factorisations;
    if (!f.ok()) {
      const bool finite = find_not_finite(r_.data(), n) < 0;
      return fail(t, finite ? StepCode::singular : StepCode::not_finite, f.unknown);
    }
  }
  solve_for_correction(violation(t));
  t.status.correction = scales_.of_coordinates(r_.data(), &t.status.coordinate);
  return true;
}

/// The multipliers that balance the correction, λ + α (Φ + Φz δ); force_: their change. Once the constraints
/// are satisfied the multipliers stay: near singular positions they would change for dozens of iterations
/// along directions that hardly act, while the motion does not change any more.
void IndexThree::update_multipliers(Attempt& t, int iteration) {
  const double penalty_factor = weights_.penalty / motion_.scale;
  const double *alpha = system_.penalty(), *phi = violation(t);
  const int m = system_.equations();
  t.settled = !t.precise && iteration >= iterations_before_settling && t.violation <= t.position_tolerance;
  if (options_.fixed_cost) before_ = lambda_;
  for (int k = 0; k < m; ++k) force_[k] = penalty_factor * alpha[k] * (phi[k] + impulse_[k]);
  if (!t.settled) lambda_ += force_;
}

/// Moves to the next iterate.
bool IndexThree::apply_correction(const State& s, Attempt& t) {
  if (const int bad = find_not_finite(r_.data(), system_.velocities()); bad >= 0)
    return fail(t, StepCode::not_finite, bad);
  t.shortened = searches_ && t.newton.corrections >= search_from && shorten_correction(s, t);
  if (!t.shortened) system_.compose(motion_.x.data(), r_.data());
  if (t.newton.slow && !t.leaps) mixing_.mix(motion_.x, lambda_, r_);
  return true;
}

/// Velocities onto the constraints. The factorised matrix belongs to an earlier iterate, so that a projection
/// leaves a small violation, which the next removes.
void IndexThree::project_velocities(Attempt& t) {
  Eigen::VectorXd& v = motion_.v;
  const auto evaluate = [&] { system_.kinematics(t.time, motion_.q.data(), v.data(), motion_.a.data()); };
  const double enough = t.velocity_tolerance, accepted = accepted_velocities * enough;
  if (!t.projected) t.rate_violation = scales_.of_equations(system_.phi_dot());
  for (int round = 0; round < most_velocity_rounds; ++round) {
    const bool first = round == 0 && !t.precise && !t.projected;
    if (scales_.of_equations(system_.phi_dot()) <= (first ? enough : accepted)) break;
    project(v.data(), system_.phi_dot(), enough);
    evaluate();
  }
  if (motion_.driven.any()) {
    r_ = v - unprojected_;
    motion_.driven.follow(t.time, motion_.q.data(), r_, force_.data(), v, false);
    evaluate();
  }
  unprojected_ -= v;

  const double change = scales_.of_coordinates(unprojected_.data());
  t.projected_away = ratio(change, projected_velocities * scales_.of_coordinates(v.data()));
  const bool satisfied = scales_.of_equations(system_.phi_dot()) <= accepted;
  t.near_singular = !satisfied || (change > singular_amplification * t.rate_violation &&
                                   change > singular_change * scales_.of_coordinates(v.data()));
  if (options_.fixed_cost && t.near_singular) {
    // A projection that diverges is worse than none.
    t.status.unconverged = true;
    v += unprojected_;
    evaluate();
  } else if (!satisfied && t.precise) {
    t.status.code = StepCode::not_converged;
    return;
  }
  scales_.of_kinds(system_.phi_dot(), t.status.velocity_violation, t.status.angular_velocity_violation);
}

/// Accelerations onto the constraints; the multipliers follow, so that they balance the projected ones:
/// M δ + Φzᵀ Δλ = 0. Near singular positions this would amplify the velocities' remaining error.
void IndexThree::project_accelerations(Attempt& t) {
  Eigen::VectorXd& a = motion_.a;
  unprojected_ = a;
  const double share = (1 - motion_.rule.alpha_f) / (1 - motion_.rule.alpha_m);
  motion_.algorithmic -= a * share;
  if (!t.precise && !t.near_singular) {
    force_.setZero();
    project(a.data(), system_.phi_ddot(), options_.acceleration_tolerance * t.accelerations);
    lambda_ += force_;
    r_ = a - unprojected_;
    motion_.driven.follow(t.time, motion_.q.data(), r_, force_.data(), a, true);
    // What comes after the step looks at the last evaluation.
    if (motion_.driven.any())
      system_.residual(t.time, motion_.q.data(), motion_.v.data(), a.data(), lambda_.data(), 0, r_.data());
    r_ = unprojected_ - a;
    t.projected_away = std::max(t.projected_away, ratio(scales_.of_coordinates(r_.data()),
                                                        projected_accelerations * t.accelerations));
  }
  motion_.algorithmic += a * share;
}

}  // namespace mimbre
