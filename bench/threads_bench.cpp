#include <benchmark/benchmark.h>

#include "mimbre/model_file.h"
#include "mimbre/simulation.h"

/// Threads that step mechanisms of one model, with laws by expressions and signals: nothing is locked, so
/// that as many run as there are cores.
namespace {

std::shared_ptr<const mimbre::Model> controlled_slider() {
  static const auto model = mimbre::Model::compile(mimbre::parse_model(R"y(
mimbre: 1
inputs:
  wanted: {start: 0.2}
signals:
  angle: {joint: crank}
  rate: {joint_velocity: crank}
  error: wanted*sin(3*t) - angle
bodies:
  crank: {mass: 1, com: [0.1, 0, 0], inertia: [1e-3, 1e-2, 1e-2]}
  rod: {mass: 1, com: [0.35, 0, 0], inertia: [1e-3, 1e-2, 1e-2]}
joints:
  crank: {type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 1, 0]}
  pin: {type: revolute, between: [crank, rod], at: [0.2, 0, 0], axis: [0, 1, 0]}
actuators:
  motor: {joint: crank, torque: "20*error*(1 + 0.1*cos(error)) - 2*rate"}
springs:
  tip: {between: [ground, rod], at: [[0.5, 0, 0.5], [0.5, 0, 0]], elastic: "40*sinh(l - 0.5)", damping: "v + 0.1*v^3"}
)y",
                                                                       "slider", "."));
  return model;
}

void steps_by_threads(benchmark::State& state) {
  mimbre::RunOptions options;
  options.step = 0.001;
  mimbre::Simulation simulation(controlled_slider(), options);
  const auto wanted = simulation.input("wanted");
  for (double value = 0; auto _ : state) {
    simulation.set_input(wanted, value = value > 0.5 ? 0 : value + 1e-3);
    if (!simulation.step().ok()) {
      state.SkipWithError("a step failed");
      break;
    }
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(steps_by_threads)->ThreadRange(1, 8)->UseRealTime()->Unit(benchmark::kMicrosecond);

}  // namespace
