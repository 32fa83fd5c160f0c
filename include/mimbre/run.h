#pragma once
#include <cstdint>
#include <functional>

#include "mimbre/simulation.h"

/// The stepping loop, timed.
namespace mimbre {

/// How many steps a run has, and how many of them lie between two outputs.
struct RunPlan {
  std::int64_t steps = 0;
  std::int64_t stride = 1;
};
/// Steps to `end` (s), and the multiple of the step nearest to `output_interval` (s; 0: every step). Throws
/// InputError when there are too many.
RunPlan plan_run(double end, double output_interval, double step);

/// Sums over the steps made so far.
struct RunTotals {
  std::int64_t steps = 0;
  std::int64_t iterations = 0;
  std::int64_t factorisations = 0;
  double cpu_seconds = 0;  ///< of this thread, of the steps alone
  double max_position_violation = 0;
  double max_velocity_violation = 0;
};

/// Simulated seconds per CPU second of stepping; larger than 1 is faster than real time. NaN when nothing was
/// measured.
double real_time_factor(const RunTotals& totals, double step);

/// Up to `count` steps; ends early when one fails or `stop` (where given, asked before each step) says so.
/// The clock is read twice per call.
StepReport advance(Simulation& simulation, std::int64_t count, RunTotals& totals,
                   const std::function<bool()>& stop = {});

}  // namespace mimbre
