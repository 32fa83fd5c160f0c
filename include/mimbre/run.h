#pragma once
#include <cstdint>
#include <functional>

#include "mimbre/simulation.h"

/// The stepping loop, timed.
namespace mimbre {

/// The steps of a run: all of them equal but for the last, which ends at the end asked for.
struct RunPlan {
  double step = 0;             ///< s
  double end = 0;              ///< s
  double output_interval = 0;  ///< s; 0: a row at every step
  std::int64_t steps = 0;
  /// The step after which the next row is due, where `made` steps have been made: the first one at or after
  /// the next multiple of the output interval, or the last one.
  std::int64_t next_row(std::int64_t made) const;
  /// How many rows there are, with that of the start.
  std::int64_t rows() const;
};
/// Steps to `end` (s). The rest of a step at the end becomes a shorter step, or, where it is less than
/// a thousandth, added to the last. Throws InputError when the step is longer than the run, or there are too
/// many. A run to 0 has no steps.
RunPlan plan_run(double end, double output_interval, double step);

/// Such a step: no run is made of less than one (but for a thousandth).
bool longer_than_run(double step, double end);

/// Sums over the steps made so far.
struct RunTotals {
  std::int64_t steps = 0;
  std::int64_t iterations = 0;
  std::int64_t factorisations = 0;
  std::int64_t repeated_steps = 0;     ///< steps that were made again in parts (RunOptions::substeps)
  std::int64_t unconverged_steps = 0;  ///< taken before their iterations converged (RunOptions::fixed_cost)
  double cpu_seconds = 0;              ///< of this thread, of the steps alone
  Violations violations;               ///< the largest of the constraints
};

/// Simulated seconds (`simulated`) per CPU second of stepping; larger than 1 is faster than real time. NaN
/// when nothing was measured.
double real_time_factor(const RunTotals& totals, double simulated);

/// Steps on until `until` of them are made in all (`totals` counts them), or one fails, or an event stops the
/// run (Simulation::stopped; that step counts when it is whole), or `stop` (where given, asked before each
/// step) returns true. The clock is read twice per call.
StepReport advance(Simulation& simulation, const RunPlan& plan, std::int64_t until, RunTotals& totals,
                   const std::function<bool()>& stop = {});

}  // namespace mimbre
