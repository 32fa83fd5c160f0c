#include "support/run.h"

namespace mimbre::test {

IntegratorOptions newmark(double step, double xi) {
  IntegratorOptions o;
  o.step = step;
  o.rule = IntegratorOptions::Rule::newmark;
  o.xi = xi;
  o.tolerance = 1e-7;
  return o;
}

IntegratorOptions generalised_alpha(double step, double rho) {
  IntegratorOptions o;
  o.step = step;
  o.rho = rho;
  o.tolerance = 1e-7;
  return o;
}

State initial_state(const std::shared_ptr<const Model>& model) {
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

Outcome run(const std::shared_ptr<const Model>& model, const IntegratorOptions& options, double duration,
            State start, const std::function<void(relative::RelativeSystem&, const State&)>& watch) {
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

Outcome run(const std::shared_ptr<const Model>& model, const IntegratorOptions& options, double duration) {
  return run(model, options, duration, initial_state(model));
}

double order(const Eigen::VectorXd& coarse, const Eigen::VectorXd& middle, const Eigen::VectorXd& fine) {
  return std::log2((coarse - middle).norm() / (middle - fine).norm());
}

}  // namespace mimbre::test
