#include "integrate/radau/radau.h"

#include <algorithm>
#include <cmath>

#include "integrate/drift.h"
#include "integrate/explicit/close_loops.h"
#include "integrate/slow_motion.h"
#include "integrate/vectors.h"

namespace mimbre {

using linalg::Complex;
using radau::stages;

namespace {

/// κ: an iteration leaves about that share of a violation of Φ̈.
constexpr double inertia_penalty = 1e6;
/// The error of the iterations as a share of the accuracy: this, or the accuracy's root where that is less
/// (Hairer, Wanner 1996, IV.8). Without an accuracy: of what is of the mechanism's size, this times the
/// tolerance.
constexpr double share_of_accuracy = 0.03, share_of_tolerance = 1e-5;
/// Of positions by the mechanism's size: round-off, and what corrections stop at where they no longer shrink.
constexpr double least_correction = 1e-14, stagnant_correction = 1e-10, stagnant_rate = 0.8;
/// A step may be that much longer than the one before if the polynomial of that is to lead through it.
constexpr double longest_extrapolation = 2.5;
/// Iterations that contract worse than this have diverged.
constexpr double diverging = 1;

double newton_tolerance(const IntegratorOptions& options) {
  const double asked = options.accuracy > 0
                           ? std::min(share_of_accuracy, std::sqrt(options.accuracy)) * options.accuracy
                           : share_of_tolerance * options.tolerance;
  return std::max(asked, least_correction);
}

}  // namespace

RadauStepper::RadauStepper(System& system, const IntegratorOptions& options)
    : Stepper(options),
      system_(system),
      slow_(slow_motion(options)),
      penalty_(inertia_penalty),
      newton_tolerance_(newton_tolerance(options)),
      matrices_(system, inertia_penalty),
      complex_(static_cast<std::size_t>(system.velocities())) {
  const int n = system.velocities(), m = system.equations();
  for (Stage& stage : stages_) {
    stage.q.setZero(system.positions());
    for (Eigen::VectorXd* x :
         {&stage.x, &stage.v, &stage.a, &stage.r, &stage.rate, &stage.change, &stage.last_a})
      x->setZero(n);
    for (Eigen::VectorXd* x : {&stage.multipliers, &stage.g, &stage.last_multipliers}) x->setZero(m);
  }
  q_.setZero(system.positions());
  g_.setZero(m);
  for (Eigen::VectorXd* x : {&v_, &r_, &d_, &zero_, &by_x_, &by_v_, &error_x_, &error_v_}) x->setZero(n);
}

void RadauStepper::transfer(StateTransfer& transfer) {
  transfer(last_step_);
  for (Stage& stage : stages_) transfer(stage.last_a, stage.last_multipliers);
}

/// Accelerations and multipliers at the stages: the polynomial of the step before, or none.
void RadauStepper::guess(const State& s) {
  const double h = options_.step;
  const bool extrapolates = last_step_ > 0 && h <= longest_extrapolation * last_step_;
  for (int i = 0; i < stages; ++i) {
    Stage& stage = stages_[i];
    if (extrapolates) {
      const radau::Row weights = radau::polynomial(1 + radau::c[i] * h / last_step_);
      stage.a.setZero();
      stage.multipliers.setZero();
      for (int j = 0; j < stages; ++j) {
        stage.a += weights[j] * stages_[j].last_a;
        stage.multipliers += weights[j] * stages_[j].last_multipliers;
      }
    } else {
      // What starts out of balance has accelerations that no step follows.
      if (last_step_ > 0)
        stage.a = s.a;
      else
        stage.a.setZero();
      stage.multipliers = s.multipliers;
    }
    stage.x = radau::c[i] * h * s.v;
  }
  follow(s);
  follow(s);
}

/// Velocities and positions from accelerations; of rotations from the positions before.
void RadauStepper::follow(const State& s) {
  const double h = options_.step;
  for (int i = 0; i < stages; ++i) {
    Stage& stage = stages_[i];
    stage.v = s.v;
    for (int j = 0; j < stages; ++j) stage.v += h * radau::A[i][j] * stages_[j].a;
  }
  for (Stage& stage : stages_) system_.increment_rate(stage.x.data(), stage.v.data(), stage.rate.data());
  for (int i = 0; i < stages; ++i) {
    Stage& stage = stages_[i];
    stage.x.setZero();
    for (int j = 0; j < stages; ++j) stage.x += h * radau::A[i][j] * stages_[j].rate;
  }
}

/// Residuals and Φ̈ at the stages.
bool RadauStepper::evaluate(const State& s, StepStatus& status) {
  const int n = system_.velocities();
  ++status.iterations;
  for (int i = 0; i < stages; ++i) {
    Stage& stage = stages_[i];
    const double h = radau::c[i] * options_.step;
    system_.retract(s.q.data(), stage.x.data(), stage.q.data());
    system_.enter(s.u.data(), s.z.data(), h);
    system_.residual(s.time + h, stage.q.data(), stage.v.data(), stage.a.data(), stage.multipliers.data(), 0,
                     stage.r.data());
    std::copy_n(system_.phi_ddot(), system_.equations(), stage.g.data());
    if (const int bad = find_not_finite(stage.r.data(), n); bad >= 0) {
      status.code = StepCode::not_finite;
      status.coordinate = bad;
      return false;
    }
  }
  return true;
}

/// r, g ← changes of a and of the multipliers that take r and g back, by the real matrix.
void RadauStepper::solve(Eigen::VectorXd& r, Eigen::VectorXd& g) {
  const double* alpha = system_.penalty();
  const int m = system_.equations();
  for (int k = 0; k < m; ++k) g[k] *= penalty_ * alpha[k];
  if (m > 0) system_.add_jacobian_transposed(g.data(), 1, r.data());
  r = -r;
  matrices_.solve(r.data());
  if (m > 0) system_.jacobian_times(r.data(), g_.data());
  for (int k = 0; k < m; ++k) g[k] += penalty_ * alpha[k] * g_[k];
}

/// From the residuals and Φ̈ at the stages to the changes of accelerations and multipliers there.
void RadauStepper::correct() {
  const auto transform = [&](const std::array<radau::Row, stages>& by, Eigen::VectorXd Stage::*x) {
    for (Eigen::Index k = 0; k < (stages_[0].*x).size(); ++k) {
      const double y[stages] = {(stages_[0].*x)[k], (stages_[1].*x)[k], (stages_[2].*x)[k]};
      for (int i = 0; i < stages; ++i)
        (stages_[i].*x)[k] = by[i][0] * y[0] + by[i][1] * y[1] + by[i][2] * y[2];
    }
  };
  transform(radau::T_inverse, &Stage::r);
  transform(radau::T_inverse, &Stage::g);
  solve(stages_[0].r, stages_[0].g);
  // The pair: the second as real, the third as imaginary part.
  const double* alpha = system_.penalty();
  const int m = system_.equations();
  for (int i = 1; i < stages; ++i) {
    Stage& stage = stages_[i];
    for (int k = 0; k < m; ++k) stage.g[k] *= penalty_ * alpha[k];
    if (m > 0) system_.add_jacobian_transposed(stage.g.data(), 1, stage.r.data());
  }
  Eigen::VectorXd &re = stages_[1].r, &im = stages_[2].r;
  for (std::size_t k = 0; k < complex_.size(); ++k)
    complex_[k] = {-re[static_cast<Eigen::Index>(k)], -im[static_cast<Eigen::Index>(k)]};
  matrices_.solve(complex_.data());
  for (std::size_t k = 0; k < complex_.size(); ++k) {
    re[static_cast<Eigen::Index>(k)] = complex_[k].re;
    im[static_cast<Eigen::Index>(k)] = complex_[k].im;
  }
  for (int i = 1; i < stages; ++i) {
    Stage& stage = stages_[i];
    if (m > 0) system_.jacobian_times(stage.r.data(), g_.data());
    for (int k = 0; k < m; ++k) stage.g[k] += penalty_ * alpha[k] * g_[k];
  }
  transform(radau::T, &Stage::r);
  transform(radau::T, &Stage::g);
}

/// Takes the changes over. Returns how far positions go by them, and velocities by those at play.
double RadauStepper::apply(const State& s) {
  const Scales& scales = system_.scales();
  const double h = options_.step;
  for (int i = 0; i < stages; ++i) {
    Stage& stage = stages_[i];
    stage.a += stage.r;
    stage.multipliers += stage.g;
    stage.change.setZero();
    for (int j = 0; j < stages; ++j) stage.change += h * radau::A[i][j] * stages_[j].r;
  }
  const double play =
      std::max({scales.rate(s.v.data()), scales.of_coordinates(stages_.back().v.data()), slow_});
  double size = 0;
  for (Stage& stage : stages_) {
    size = std::max(size, scales.of_coordinates(stage.change.data()) / play);
    stage.rate = stage.x;
  }
  for (int i = 0; i < stages; ++i)
    for (int j = 0; j < stages; ++j) stages_[i].x += h * radau::A[i][j] * stages_[j].change;
  for (Stage& stage : stages_) stage.change = stage.rate;
  follow(s);
  for (Stage& stage : stages_) {
    stage.change = stage.x - stage.change;
    size = std::max(size, scales.of_coordinates(stage.change.data()));
  }
  return size;
}

/// Accelerations and multipliers at the stages, by iterations with the matrices of the start.
bool RadauStepper::iterate(const State& s, StepStatus& status) {
  double before = 0, rate = 1;
  for (int iteration = 0; iteration < options_.max_iterations; ++iteration) {
    if (!evaluate(s, status)) return false;
    correct();
    const double size = apply(s);
    status.correction = size;
    if (!std::isfinite(size)) {
      status.code = StepCode::not_finite;
      return false;
    }
    if (iteration > 0) rate = size / std::max(before, 1e-300);
    before = size;
    const double left = rate < 1 ? rate / (1 - rate) * size : size;
    if ((iteration > 0 && left <= newton_tolerance_) || size <= least_correction ||
        size <= 0.01 * newton_tolerance_)
      return true;
    if (iteration > 1 && rate > stagnant_rate && size <= stagnant_correction) return true;
    if (iteration > 1 && rate >= diverging) break;
  }
  status.code = StepCode::not_converged;
  system_.scales().of_coordinates(stages_.back().change.data(), &status.coordinate);
  return false;
}

/// The estimated error over the accuracy, by the scales of the coordinates; of velocities by these times how
/// fast the mechanism goes. The system of the real eigenvalue takes from it what stiff motions blow up; where
/// it is large, once more from the slope at where it leads to.
double RadauStepper::error_over_accuracy(const State& s) {
  const Scales& scales = system_.scales();
  const int n = system_.velocities();
  const double h = options_.step, step = h / radau::gamma;
  by_x_.setZero();
  by_v_.setZero();
  for (int i = 0; i < stages; ++i) {
    by_x_ += radau::error[i] / h * stages_[i].x;
    by_v_ += radau::error[i] / h * (stages_[i].v - s.v);
  }
  // (1/s) e_x − e_v = g_x and M e_v/s + C e_v + K e_x = M g_v, with g = f_0 + Σ e_i (y_i − y_0)/h: forces
  // where s g_x leads to include K s g_x.
  system_.enter(s.u.data(), s.z.data(), 0);
  error_x_.setZero();
  error_v_.setZero();
  double error = 0;
  const double rate = std::max({scales.rate(s.v.data()), scales.of_coordinates(s.v.data()), slow_});
  for (int round = 0; round < 2; ++round) {
    v_ = s.v + error_v_;
    d_ = v_ + by_x_;  // g_x
    error_x_ += step * d_;
    system_.retract(s.q.data(), error_x_.data(), q_.data());
    error_x_ = -by_v_;
    system_.residual(s.time, q_.data(), v_.data(), error_x_.data(), stages_.front().multipliers.data(), 0,
                     r_.data());
    Eigen::VectorXd& g = stages_.front().g;
    std::copy_n(system_.phi_ddot(), system_.equations(), g.data());
    solve(r_, g);
    error_v_ = step * r_;
    error_x_ = step * (d_ + error_v_);
    double sum = 0;
    for (int k = 0; k < n; ++k) {
      const double scale = options_.accuracy * scales.coordinates[static_cast<std::size_t>(k)];
      const double x = error_x_[k] / scale, v = error_v_[k] / (scale * rate);
      sum += x * x + v * v;
    }
    error = n > 0 ? std::sqrt(sum / (2 * n)) : 0;
    if (!(error >= 1)) break;
  }
  return error;
}

/// Puts q_ and v_ onto the constraints, by the least motion in the sense of the real matrix there.
void RadauStepper::close(double t) {
  const double s = options_.step / radau::gamma;
  const MatrixWeights weights{s, s * s, penalty_};
  const Stage& last = stages_.back();
  system_.residual(t, q_.data(), v_.data(), last.a.data(), last.multipliers.data(), 0, r_.data());
  if (!system_.factor(q_.data(), weights).ok()) return;
  const auto take_back = [&](const double* violation, Eigen::VectorXd& d) {
    for (int k = 0; k < system_.equations(); ++k) g_[k] = -penalty_ * system_.penalty()[k] * violation[k];
    d.setZero();
    system_.add_jacobian_transposed(g_.data(), 1, d.data());
    system_.solve(d.data());
  };
  close_positions_by(system_, t, q_, v_, zero_, d_, take_back);
  close_velocities_by(system_, t, q_, v_, zero_, d_, take_back);
}

StepStatus RadauStepper::step(State& s) {
  StepStatus status;
  const double end = s.time + options_.step;
  system_.begin_step(s.q.data());
  begins_ = !s.started;
  if (begins_) last_step_ = 0;
  guess(s);
  system_.enter(s.u.data(), s.z.data(), options_.step);
  system_.residual(s.time, s.q.data(), s.v.data(), stages_.front().a.data(), s.multipliers.data(), 0,
                   r_.data());
  if (const int bad = find_not_finite(r_.data(), system_.velocities()); bad >= 0) {
    status.code = StepCode::not_finite;
    status.coordinate = bad;
    return status;
  }
  status.factorisations += 2;
  if (const linalg::FactorStatus f = matrices_.factor(s.q.data(), options_.step); !f.ok()) {
    status.code = StepCode::singular;
    status.coordinate = f.unknown;
    return status;
  }
  if (!iterate(s, status)) return status;
  if (options_.accuracy > 0) status.error = error_over_accuracy(s);
  const Stage& last = stages_.back();
  system_.retract(s.q.data(), last.x.data(), q_.data());
  v_ = last.v;
  system_.enter(s.u.data(), s.z.data(), options_.step);
  if (system_.equations() > 0) close(end);
  system_.kinematics(end, q_.data(), v_.data(), last.a.data());
  if (status.code = find_drift(system_, options_.drift_limit, status); status.code != StepCode::ok)
    return status;
  if (const int bad = find_not_finite(v_.data(), system_.velocities()); bad >= 0) {
    status.code = StepCode::not_finite;
    status.coordinate = bad;
    return status;
  }
  s.time = end;
  s.q = q_;
  s.v = v_;
  s.a = s.algorithmic = last.a;
  s.multipliers = last.multipliers;
  s.started = true;
  last_step_ = options_.step;
  for (Stage& stage : stages_) {
    stage.last_a = stage.a;
    stage.last_multipliers = stage.multipliers;
  }
  return status;
}

void RadauStepper::begun(State& s) const {
  if (!begins_) return;
  const radau::Row weights = radau::polynomial(0);
  s.a.setZero();
  s.multipliers.setZero();
  for (int i = 0; i < stages; ++i) {
    s.a += weights[i] * stages_[i].a;
    s.multipliers += weights[i] * stages_[i].multipliers;
  }
  s.algorithmic = s.a;
}

}  // namespace mimbre
