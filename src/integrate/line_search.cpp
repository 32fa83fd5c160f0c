#include <cmath>

#include "integrate/index3.h"

/// How far a step of index3 follows a correction. Across friction in joints whose bristles hardly give,
/// Newton's corrections leap from sliding forth to sliding back and never meet the narrow range between, in
/// which it sticks.
namespace mimbre {
namespace {

// A correction is shortened where at its end the residual along it has turned and is left with more than this
// share of itself; evaluations of it at most, and corrections that return one of them to the constraints.
constexpr double left_along = 0.5;
constexpr int most_evaluations = 30, most_returns = 3;

}  // namespace

/// Moves the iterate onto the constraints, which a straight line leaves where they are curved.
void IndexThree::return_to_constraints(const State& s, Attempt& t) {
  const int m = system_.equations();
  const double* alpha = system_.penalty();
  for (int round = 0; m > 0 && round < most_returns; ++round) {
    motion_.from_increment(s);
    system_.kinematics(t.time, motion_.q.data(), motion_.v.data(), motion_.a.data());
    if (t.inherits) leave_inherited();
    const double* phi = violation(t);
    if (scales_.of_equations(phi) <= t.position_tolerance) return;
    r_.setZero();
    if (!system_.solve_with_constraint_forces(1, weights_.penalty, phi, r_.data(), rates_.data())) {
      for (int k = 0; k < m; ++k) g_[k] = alpha[k] * phi[k];
      system_.add_jacobian_transposed(g_.data(), -weights_.penalty, r_.data());
      system_.solve(r_.data());
    }
    system_.compose(motion_.x.data(), r_.data());
  }
}

/// The residual of the step along the correction line_, at this share of it from line_x_. Multipliers go
/// along: line_lambda_ are those at its end.
double IndexThree::along_correction(const State& s, Attempt& t, double share) {
  motion_.x = line_x_;
  r_ = share * line_;
  system_.compose(motion_.x.data(), r_.data());
  if (share > 0) return_to_constraints(s, t);
  if (!t.settled) lambda_ = line_lambda_ + (share - 1) * force_;
  evaluate(s, t);
  return line_.dot(r_);
}

/// Whether the correction in r_ leads too far. Then the iterate is moved along it to where the residual along
/// it is small, by regula falsi with halved ordinates (Dowell and Jarratt, BIT 11, 1971, the "Illinois"
/// algorithm). Else nothing is moved.
bool IndexThree::shorten_correction(const State& s, Attempt& t) {
  const int most = (searching_attempts - 1) * options_.max_iterations;
  if (t.status.iterations >= most) return false;
  line_ = r_;
  line_x_ = motion_.x;
  line_lambda_ = lambda_;
  const Attempt before = t;
  // The start last, so that the evaluation is there again where nothing is moved.
  double low = 0, high = 1, at_high = along_correction(s, t, high), at_low = along_correction(s, t, low);
  const double enough = left_along * std::abs(at_low);
  bool leaps = at_low < 0 && at_high > enough && std::isfinite(at_high);
  double at = at_high;
  for (int side = 0, k = 0;
       leaps && std::abs(at) > enough && k < most_evaluations && t.status.iterations < most; ++k) {
    const double share = (low * at_high - high * at_low) / (at_high - at_low);
    at = along_correction(s, t, share);
    (at < 0 ? low : high) = share;
    (at < 0 ? at_low : at_high) = at;
    const int now = at < 0 ? -1 : 1;
    if (now == side) (now < 0 ? at_high : at_low) *= 0.5;
    side = now;
    leaps = std::isfinite(at);
  }
  const int evaluations = t.status.iterations;
  t = before;
  t.status.iterations = evaluations;
  r_ = line_;
  t.leaps = t.leaps || leaps;
  if (leaps) return true;
  motion_.x = line_x_;
  lambda_ = line_lambda_;
  return false;
}

}  // namespace mimbre
