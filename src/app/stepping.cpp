#include "app/stepping.h"

#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "math/cpu_time.h"

namespace mimbre::app {
namespace {

// Years of computing; a larger number is a mistake, and might not fit an integer.
constexpr double most_steps = 1e13;

std::atomic<bool> stop_wanted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal's handler sets it");

}  // namespace

Plan plan_run(double end, double output_interval, double step) {
  const double steps = std::round(end / step);
  if (!(steps <= most_steps))
    throw InputError(Mark{}, fmt::format("a run to {} s has too many steps of {} s", end, step));
  const double stride = std::min(std::round(output_interval / step), most_steps);
  return {static_cast<std::int64_t>(steps), std::max<std::int64_t>(1, static_cast<std::int64_t>(stride))};
}

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = [](int) { stop_wanted.store(true, std::memory_order_relaxed); };
  sigemptyset(&action.sa_mask);
  // Writes that are under way go on; a second signal finds the default action.
  action.sa_flags = SA_RESTART | SA_RESETHAND;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool interrupted() { return stop_wanted.load(std::memory_order_relaxed); }

StepReport advance(Simulation& simulation, std::int64_t count, Totals& totals) {
  StepReport report;
  const double start = thread_cpu_seconds();
  for (std::int64_t k = 0; k < count && !interrupted(); ++k) {
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

}  // namespace mimbre::app
