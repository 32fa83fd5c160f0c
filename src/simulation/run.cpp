#include "mimbre/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/cpu_time.h"

namespace mimbre {

// Years of computing; a larger number is a mistake, and might not fit an integer.
constexpr double most_steps = 1e13;

RunPlan plan_run(double end, double output_interval, double step) {
  const double steps = std::round(end / step);
  if (!(steps <= most_steps))
    throw InputError(Mark{}, fmt::format("a run to {} s has too many steps of {} s", end, step));
  const double stride = std::min(std::round(output_interval / step), most_steps);
  return {static_cast<std::int64_t>(steps), std::max<std::int64_t>(1, static_cast<std::int64_t>(stride))};
}

double real_time_factor(const RunTotals& totals, double step) {
  if (totals.steps == 0 || !(totals.cpu_seconds > 0)) return std::numeric_limits<double>::quiet_NaN();
  return static_cast<double>(totals.steps) * step / totals.cpu_seconds;
}

StepReport advance(Simulation& simulation, std::int64_t count, RunTotals& totals,
                   const std::function<bool()>& stop) {
  StepReport report;
  const double start = thread_cpu_seconds();
  for (std::int64_t k = 0; k < count && !(stop && stop()); ++k) {
    report = simulation.step();
    totals.iterations += report.iterations;
    totals.factorisations += report.factorisations;
    if (!report.ok()) break;
    ++totals.steps;
    totals.max_position_violation = std::max(totals.max_position_violation, report.position_violation);
    totals.max_velocity_violation = std::max(totals.max_velocity_violation, report.velocity_violation);
  }
  totals.cpu_seconds += thread_cpu_seconds() - start;
  return report;
}

}  // namespace mimbre
