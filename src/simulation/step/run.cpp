#include "mimbre/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/cpu_time.h"

namespace mimbre {

// Years of computing; a larger number is a mistake, and might not fit an integer.
constexpr double most_steps = 1e13;

// A rest of a step shorter than this part of it is no step of its own: steps as short as rounding leaves them
// would be hard on the integrator for nothing.
constexpr double least_part = 1e-3;

RunPlan plan_run(double end, double output_interval, double step) {
  const double whole = end / step;
  if (!(whole <= most_steps))
    throw InputError(Mark{}, fmt::format("a run to {} s has too many steps of {} s", end, step));
  if (longer_than_run(step, end))
    throw InputError(Mark{},
                     fmt::format("the step of {} s is longer than the run, which ends at {} s; give a "
                                 "shorter step or a later end",
                                 step, end));
  // Of a run that is hardly shorter than one step, that step.
  const double steps = end > 0 ? std::max(1.0, std::ceil(whole - least_part)) : 0;
  // A whole number of steps but for rounding: then the end is the time that they come to, through which a
  // longer run goes, too, so that it may go on from there with the same bits.
  const double multiple = std::round(whole) * step;
  const bool whole_steps = std::abs(end - multiple) < 1e-6 * step;
  return {step, whole_steps ? multiple : end, output_interval, static_cast<std::int64_t>(steps)};
}

bool longer_than_run(double step, double end) { return end > 0 && end / step < 1 - least_part; }

std::int64_t RunPlan::next_row(std::int64_t made) const {
  if (made + 1 >= steps) return steps;
  const double interval = output_interval / step;
  if (!(interval > 1)) return made + 1;
  // In steps; a step that falls on a multiple but for rounding is at it.
  constexpr double rounding = 1e-6;
  const double multiple = std::floor((static_cast<double>(made) + rounding) / interval) + 1;
  const double next = std::ceil(multiple * interval - rounding);
  return next < static_cast<double>(steps) ? static_cast<std::int64_t>(next) : steps;
}

std::int64_t RunPlan::rows() const {
  std::int64_t count = 1;
  for (std::int64_t made = 0; made < steps; made = next_row(made)) ++count;
  return count;
}

double real_time_factor(const RunTotals& totals, double simulated) {
  if (totals.steps == 0 || !(totals.cpu_seconds > 0)) return std::numeric_limits<double>::quiet_NaN();
  return simulated / totals.cpu_seconds;
}

StepReport advance(Simulation& simulation, const RunPlan& plan, std::int64_t until, RunTotals& totals,
                   const std::function<bool()>& stop) {
  StepReport report;
  const double start = thread_cpu_seconds();
  while (totals.steps < until && !(stop && stop())) {
    const double from = simulation.time();
    report = totals.steps + 1 < plan.steps ? simulation.step() : simulation.step_to(plan.end);
    totals.iterations += report.iterations;
    totals.factorisations += report.factorisations;
    if (!report.ok()) break;
    // One that an event ends early counts when the rest of it is made.
    if (!simulation.stopped() || simulation.time() - from > 0.999999 * simulation.step_size()) ++totals.steps;
    if (report.substeps > 1) ++totals.repeated_steps;
    if (report.unconverged) ++totals.unconverged_steps;
    totals.violations.raise(report);
    if (simulation.stopped()) break;
  }
  totals.cpu_seconds += thread_cpu_seconds() - start;
  return report;
}

}  // namespace mimbre
