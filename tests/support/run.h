#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "dynamics/relative/system.h"
#include "integrate/index3.h"
#include "integrate/initial.h"
#include "mimbre/simulation.h"

/// Runs of the integrator itself, without what Simulation does around it.
namespace mimbre::test {

inline IntegratorOptions newmark(double step, double xi = 0) {
  IntegratorOptions o;
  o.step = step;
  o.rule = IntegratorOptions::Rule::newmark;
  o.xi = xi;
  o.tolerance = 1e-7;
  return o;
}

inline IntegratorOptions generalised_alpha(double step, double rho) {
  IntegratorOptions o;
  o.step = step;
  o.rho = rho;
  o.tolerance = 1e-7;
  return o;
}

inline State initial_state(const std::shared_ptr<const Model>& model) {
  const Simulation::Snapshot s = Simulation(model).save();
  State state;
  state.time = s.time;
  state.q = s.q;
  state.v = s.v;
  state.a = s.a;
  state.algorithmic = s.algorithmic;
  state.multipliers = s.multipliers;
  return state;
}

struct Outcome {
  State state;
  int failed_step = -1;
  double position_violation = 0, velocity_violation = 0;  ///< largest of all steps
  int iterations = 0;
};

/// From `start` over `duration`; `watch` (optional) sees every accepted state, kinematics evaluated.
inline Outcome run(const std::shared_ptr<const Model>& model, const IntegratorOptions& options,
                   double duration, State start,
                   const std::function<void(relative::RelativeSystem&, const State&)>& watch = {}) {
  relative::RelativeSystem system(model->compiled());
  IndexThree integrator(system, options);
  Outcome r;
  r.state = std::move(start);
  const int steps = static_cast<int>(std::lround(duration / options.step));
  for (int k = 0; k < steps; ++k) {
    const StepStatus status = integrator.step(r.state);
    if (status.code != StepCode::ok) {
      r.failed_step = k;
      return r;
    }
    r.iterations += status.iterations;
    r.position_violation = std::max(r.position_violation, status.position_violation);
    r.velocity_violation = std::max(r.velocity_violation, status.velocity_violation);
    if (!watch) continue;
    system.kinematics(r.state.time, r.state.q.data(), r.state.v.data(), r.state.a.data());
    watch(system, r.state);
  }
  return r;
}

inline Outcome run(const std::shared_ptr<const Model>& model, const IntegratorOptions& options,
                   double duration) {
  return run(model, options, duration, initial_state(model));
}

/// log2 of the ratio of successive differences of x at steps h, h/2, h/4.
inline double order(const Eigen::VectorXd& coarse, const Eigen::VectorXd& middle,
                    const Eigen::VectorXd& fine) {
  return std::log2((coarse - middle).norm() / (middle - fine).norm());
}

}  // namespace mimbre::test
