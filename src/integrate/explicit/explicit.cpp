#include "integrate/explicit/explicit.h"

#include <algorithm>
#include <cmath>

#include "integrate/drift.h"
#include "integrate/explicit/close_loops.h"
#include "integrate/explicit/runge_kutta.h"
#include "integrate/slow_motion.h"
#include "integrate/vectors.h"

namespace mimbre {
namespace {

/// Matrices of the projection.
constexpr int matrices_of_closing = 2;
/// What the difference of two stages says of the fastest motion counts where it is this share of the
/// accelerations at play: otherwise it is round-off.
constexpr double felt = 1e-8;

}  // namespace

ExplicitStepper::ExplicitStepper(System& system, const IntegratorOptions& options)
    : Stepper(options),
      system_(system),
      eighth_(options.rule == IntegratorOptions::Rule::dopri853),
      slow_(slow_motion(options)),
      accelerations_(system, options.tolerance) {
  const int n = system.velocities(), m = system.equations();
  for (Eigen::VectorXd* y : {&v_, &x_, &r_, &zero_}) y->setZero(n);
  for (Eigen::VectorXd* y : {&multipliers_, &first_multipliers_}) y->setZero(m);
  q_.setZero(system.positions());
  slopes_.resize(1 + (eighth_ ? dopri853.stages : rk4.stages));
  for (Slope& slope : slopes_) {
    slope.rate.setZero(n);
    slope.a.setZero(n);
  }
}

/// Puts q_ and v_ onto the constraints, by the least motion in the sense of the inertia. The matrix is that
/// of the last stage, which lies near; where that does not lead there, of the end itself.
bool ExplicitStepper::close(double t, StepStatus& status) {
  if (system_.equations() == 0) return true;
  const auto take_back = [&](const double* violation, Eigen::VectorXd& d) {
    accelerations_.take_back(violation, d);
  };
  for (int matrix = 0; matrix < matrices_of_closing; ++matrix) {
    // The residual lets the matrix follow.
    if (matrix > 0 && !accelerations_.find(t, q_, v_, r_, multipliers_, status)) return false;
    if (close_positions_by(system_, t, q_, v_, zero_, r_, take_back)) break;
  }
  close_velocities_by(system_, t, q_, v_, zero_, r_, take_back);
  return true;
}

/// From the first slope to the motion and the slope at the end.
template <class Method>
bool ExplicitStepper::make(const Method& method, const State& s, StepStatus& status) {
  const double h = options_.step;
  const auto move = [&](const auto& weights, std::size_t count) {
    x_.setZero();
    v_ = s.v;
    for (std::size_t j = 0; j < count; ++j) {
      if (weights[j] == 0) continue;
      x_ += h * weights[j] * slopes_[j].rate;
      v_ += h * weights[j] * slopes_[j].a;
    }
    system_.retract(s.q.data(), x_.data(), q_.data());
  };
  for (std::size_t i = 1; i < method.stages; ++i) {
    move(method.a[i], i);
    system_.enter(s.u.data(), s.z.data(), method.c[i] * h);
    if (!accelerations_.find(s.time + method.c[i] * h, q_, v_, slopes_[i].a, multipliers_, status))
      return false;
    system_.increment_rate(x_.data(), v_.data(), slopes_[i].rate.data());
  }
  move(method.b, method.stages);
  system_.enter(s.u.data(), s.z.data(), h);
  if (!close(s.time + h, status) ||
      !accelerations_.find(s.time + h, q_, v_, slopes_.back().a, multipliers_, status))
    return false;
  system_.increment_rate(x_.data(), v_.data(), slopes_.back().rate.data());
  if (options_.accuracy > 0) return true;  // the error's estimate shows it
  int where = -1;
  if (const double rate = fastest(method, where); rate * h > method.stable) {
    status.code = StepCode::unstable;
    status.coordinate = where;
    return false;
  }
  return true;
}

/// About the largest |λ|, 1/s, of the motions that the step excites, by two stages at the same instant
/// (Hairer and Wanner 1996, IV.2): of motions ẍ + d ẋ + ω² x = 0 no more than ω, where ω is the larger one,
/// or d. 0: nothing but round-off is felt. `coordinate`: where most.
template <class Method>
double ExplicitStepper::fastest(const Method& method, int& coordinate) const {
  const auto& scale = system_.scales().coordinates;
  const auto [first, second] = method.alike;
  const auto weight = [&](std::size_t stage, std::size_t j) {
    return stage == method.stages ? method.b[j] : method.a[stage][j];
  };
  double x = 0, v = 0, a = 0;
  for (int k = 0; k < system_.velocities(); ++k) {
    double dx = 0, dv = 0;
    for (std::size_t j = 0; j < second; ++j) {
      const double w = options_.step * (weight(second, j) - (j < first ? weight(first, j) : 0));
      dx += w * slopes_[j].rate[k];
      dv += w * slopes_[j].a[k];
    }
    const double inverse = 1 / scale[static_cast<std::size_t>(k)];
    x = std::max(x, inverse * std::abs(dx));
    v = std::max(v, inverse * std::abs(dv));
    if (const double da = inverse * std::abs(slopes_[second].a[k] - slopes_[first].a[k]); da > a) {
      a = da;
      coordinate = k;
    }
  }
  const double play = system_.scales().accelerations(slopes_[second].a.data());
  if (!(a > felt * std::max(play, slow_ * slow_))) return 0;
  // λ² |Δx| + λ |Δv| = |Δa|.
  const double root = v + std::sqrt(v * v + 4 * x * a);
  return root > 0 ? 2 * a / root : 0;
}

/// The estimated error of dopri853 over the accuracy, by the scales of the coordinates; of velocities, by
/// these times how fast the mechanism goes.
double ExplicitStepper::error_over_accuracy() const {
  const Scales& scales = system_.scales();
  const double rate = std::max({scales.rate(v_.data()), scales.of_coordinates(v_.data()), slow_});
  double fifth = 0, third = 0;
  const auto add = [&](double e5, double e3, double scale) {
    fifth += e5 * e5 / (scale * scale);
    third += e3 * e3 / (scale * scale);
  };
  const int n = system_.velocities();
  for (int k = 0; k < n; ++k) {
    double x5 = 0, x3 = 0, v5 = 0, v3 = 0;
    for (std::size_t j = 0; j < dopri853_error5.size(); ++j) {
      x5 += dopri853_error5[j] * slopes_[j].rate[k];
      x3 += dopri853_error3[j] * slopes_[j].rate[k];
      v5 += dopri853_error5[j] * slopes_[j].a[k];
      v3 += dopri853_error3[j] * slopes_[j].a[k];
    }
    const double scale = options_.accuracy * scales.coordinates[static_cast<std::size_t>(k)];
    add(x5, x3, scale);
    add(v5, v3, scale * rate);
  }
  const double sum = fifth + 0.01 * third;
  return sum > 0 ? options_.step * fifth / std::sqrt(sum * 2 * n) : 0;
}

StepStatus ExplicitStepper::step(State& s) {
  StepStatus status;
  system_.begin_step(s.q.data());
  multipliers_ = s.multipliers;
  Slope& first = slopes_.front();
  // Inputs and signals may have jumped.
  if (s.started && s.u.size() == 0) {
    first.a = s.a;
  } else {
    system_.enter(s.u.data(), s.z.data(), 0);
    if (!accelerations_.find(s.time, s.q, s.v, first.a, multipliers_, status)) return status;
  }
  first_multipliers_ = multipliers_;
  first.rate = s.v;
  const bool made = eighth_ ? make(dopri853, s, status) : make(rk4, s, status);
  if (!made) {
    // The start has accelerations: what goes wrong behind it is the step's.
    status.code = StepCode::unstable;
    return status;
  }
  if (status.code = find_drift(system_, options_.drift_limit, status); status.code != StepCode::ok)
    return status;
  if (eighth_ && options_.accuracy > 0) status.error = error_over_accuracy();
  s.time += options_.step;
  s.q = q_;
  s.v = v_;
  s.a = s.algorithmic = slopes_.back().a;
  s.multipliers = multipliers_;
  s.started = true;
  return status;
}

void ExplicitStepper::begun(State& s) const {
  if (s.started) return;
  s.a = s.algorithmic = slopes_.front().a;
  s.multipliers = first_multipliers_;
}

}  // namespace mimbre
