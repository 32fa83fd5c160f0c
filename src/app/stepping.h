#pragma once
#include <cstdint>

#include "mimbre/simulation.h"

/// The stepping loop, timed; shared by the commands that run a model.
namespace mimbre::app {

/// How many steps a run has, and how many of them lie between two outputs.
struct Plan {
  std::int64_t steps = 0;
  std::int64_t stride = 1;
};
/// Steps to `end` (s), and the multiple of the step nearest to `output_interval` (s; 0: every step). Throws
/// InputError when there are too many.
Plan plan_run(double end, double output_interval, double step);

/// Sums over the steps made so far.
struct Totals {
  std::int64_t steps = 0;
  std::int64_t iterations = 0;
  std::int64_t factorisations = 0;
  double cpu_seconds = 0;  ///< of this thread, of the steps alone
  double max_position_violation = 0;
  double max_velocity_violation = 0;
};

/// From here on an interrupt or a termination signal sets a flag instead of ending the process; a second one
/// ends it.
void catch_interrupts();
/// Whether such a signal has come.
bool interrupted();

/// Up to `count` steps; ends early when one fails or the run is interrupted. The clock is read twice per
/// call.
StepReport advance(Simulation& simulation, std::int64_t count, Totals& totals);

}  // namespace mimbre::app
