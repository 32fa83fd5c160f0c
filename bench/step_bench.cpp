#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "mimbre/model_file.h"
#include "mimbre/simulation.h"

/// The step of chains of rigid links: how its time grows with the number of bodies.
namespace {

std::string chain(std::int64_t links) {
  std::string bodies, joints;
  for (std::int64_t k = 1; k <= links; ++k) {
    bodies += fmt::format("  link{}: {{mass: 1, com: [{}, 0, 0], inertia: [0.01, 0.1, 0.1]}}\n", k,
                          static_cast<double>(k) - 0.5);
    joints += fmt::format(
        "  hinge{0}: {{type: revolute, between: [{1}, link{0}], at: [{2}, 0, 0], axis: [0, 1, 0]}}\n", k,
        k == 1 ? std::string("ground") : fmt::format("link{}", k - 1), k - 1);
  }
  return "mimbre: 1\nbodies:\n" + bodies + "joints:\n" + joints;
}

void step_of_a_chain(benchmark::State& state) {
  const auto model = mimbre::Model::compile(mimbre::parse_model(chain(state.range(0)), "chain", "."));
  mimbre::RunOptions options;
  options.step = 0.001;
  mimbre::Simulation simulation(model, options);
  const mimbre::Simulation::Snapshot start = simulation.save();
  constexpr int steps_of_a_fall = 500;
  for (int k = 0; auto _ : state) {
    if (!simulation.step().ok()) {
      state.SkipWithError("a step failed");
      break;
    }
    // A long chain falls into chaos: the same half second again and again.
    if (++k % steps_of_a_fall > 0) continue;
    state.PauseTiming();
    simulation.restore(start);
    state.ResumeTiming();
  }
  state.counters["time_per_body"] =
      benchmark::Counter(static_cast<double>(state.iterations() * state.range(0)),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(step_of_a_chain)->RangeMultiplier(4)->Range(1, 256)->Unit(benchmark::kMicrosecond);

}  // namespace
