#include <algorithm>
#include <cmath>
#include <limits>

#include "integrate/drift.h"
#include "integrate/index3.h"

/// Where a step of index3 ends: whether its iterations have converged, which iterate is the end, and whether
/// it is accepted.
namespace mimbre {
namespace {

// Corrections stop at round-off where they have not halved for that many iterations; directions that the
// constraints hardly determine multiply it.
constexpr int most_idle = 4;
constexpr double least_noise = 1e-11, noise_by_round_off = 1e4;
// Iterations continue down to this share of what the rule's own prediction is off by, or with a large
// tolerance to this multiple of it as a share.
constexpr double share_of_prediction = 3e-5, share_by_tolerance = 3;
// With a matrix of an earlier step, the iterations begin anew with one of their own from this ratio of
// corrections.
constexpr double least_contraction = 0.5;
// With a fixed iteration budget: larger corrections, by the mechanism's size, do not approach a solution.
constexpr double diverged_correction = 0.1;

}  // namespace

/// Whether the iterations end: the error left is small enough, and the constraints are satisfied.
void IndexThree::decide_convergence(Attempt& t) {
  const double error = t.newton.add(t.status.correction, t.refactored);
  if (t.newton.corrections == 1) t.first_correction = t.status.correction;
  // In a short step the tolerance alone would permit errors that add up to more than those of the rule, but
  // the error of its prediction decreases with the step as they do. Positions are known to round-off only;
  // where the constraints hardly determine a direction, corrections stop decreasing at a multiple of it.
  const bool stagnant = t.newton.idle >= most_idle && t.violation <= scales_.round_off;
  const double asked = options_.tolerance * motion_.scale * t.accelerations;
  const double share = std::max(share_of_prediction, share_by_tolerance * options_.tolerance);
  const double off = std::max(prediction_.off(scales_, motion_.x), t.first_correction);
  const double enough = stagnant ? std::max({asked, least_noise, noise_by_round_off * scales_.round_off})
                                 : std::min(asked, share * off);
  const double accepted = std::max(enough, std::numeric_limits<double>::epsilon());
  t.converged = !t.held && !t.shortened && error <= accepted &&
                t.violation * std::min(1.0, t.newton.rate) <= t.position_tolerance;
  if (!t.by_kept || t.status.factorisations > 0 || t.newton.corrections < 2) return;
  // A matrix of an earlier step is worth another two corrections. Where it does not contract, the iterate may
  // be anywhere.
  t.lost = !t.converged && t.newton.rate > least_contraction;
  if (error * t.newton.rate * t.newton.rate > accepted) t.newton.refactor = true;
}

/// Keeps the iterate with the least correction, which is its distance from the solution; the prediction if
/// all corrections are too large.
void IndexThree::keep_nearest(const Attempt& t) {
  if (t.newton.corrections > 0 && !(t.status.correction < std::min(nearest_.off, diverged_correction)))
    return;
  nearest_.off = t.status.correction;
  nearest_.x = motion_.x;
  nearest_.lambda = before_;
}

/// Positions, velocities and multipliers of the last iterate, evaluated; not converged after all if the
/// contraction rate was too optimistic.
void IndexThree::end_positions(const State& s, Attempt& t) {
  // If the iterations diverged: the iterate that was nearest to the solution.
  const bool diverged = !t.converged && t.status.correction > std::min(nearest_.off, diverged_correction);
  if (diverged) {
    motion_.x = nearest_.x;
    lambda_ = nearest_.lambda;
    t.settled = false;
  }
  motion_.from_increment(s);
  // Not the penalty's force of the remaining violation, which is round-off times a large number.
  if (t.settled) lambda_ += force_;
  force_.setZero();
  t.velocity_tolerance = options_.velocity_tolerance * scales_.rate(motion_.v.data());
  // Without gravity the rate is the mechanism's own, at rest that of round-off.
  if (!(scales_.acceleration > 0))
    t.velocity_tolerance = std::max(t.velocity_tolerance, scales_.round_off / usual_step_);
  unprojected_ = motion_.v;
  t.projected = false;
  if (!t.precise && !t.newton.slow && !diverged) project_expected_velocities(t);
  system_.kinematics(t.time, motion_.q.data(), motion_.v.data(), motion_.a.data());
  scales_.of_kinds(system_.phi(), t.status.position_violation, t.status.angle_violation);
  if (!(scales_.of_equations(system_.phi()) <= accepted_positions * t.position_tolerance))
    t.converged = false;
}

/// Projects velocities before they are evaluated: the last correction is small, so that its effect on the
/// rates of the constraints is known.
void IndexThree::project_expected_velocities(Attempt& t) {
  const int m = system_.equations();
  if (m == 0) return;
  const double* phi_dot = system_.phi_dot();
  for (int k = 0; k < m; ++k) rates_[k] = phi_dot[k] + motion_.rate * impulse_[k];
  t.rate_violation = scales_.of_equations(rates_.data());
  t.projected = t.rate_violation > t.velocity_tolerance;
  if (t.projected) project(motion_.v.data(), rates_.data(), t.velocity_tolerance);
}

/// Whether the iterations converged, or the fixed budget permits to continue with a position that is still
/// one of the mechanism.
bool IndexThree::accept_positions(Attempt& t) {
  if (t.converged) return true;
  if (!options_.fixed_cost) {
    t.status.code = StepCode::not_converged;
    return false;
  }
  t.status.unconverged = true;
  t.status.code = check_end(system_, motion_, options_.drift_limit, t.status);
  return t.status.code == StepCode::ok;
}

}  // namespace mimbre
