#include "app/reproduce/reproduce_lab.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "app/common.h"
#include "app/terminal/interrupts.h"
#include "mimbre/model_file.h"
#include "mimbre/run.h"

namespace mimbre::app {
namespace {

constexpr double reference_step = 1e-4;
constexpr double compared_seconds = 3;
constexpr double tip_reference_step = 1e-3, tip_interval = 0.01;
constexpr int longest_milliseconds = 50, shortest_milliseconds = 10;
/// Times are the least of as many runs as it takes to trust them, and no more than is bearable.
constexpr int least_runs = 3, most_runs = 20;
constexpr double enough_seconds = 0.1, too_many_seconds = 3;

std::string key(const Case& c) {
  std::string text = c.file;
  for (const auto& [name, value] : c.settings) text += ' ' + name + '=' + value;
  return text;
}

/// With everything of the options that a table varies.
std::string key(const Case& c, int milliseconds) {
  const RunOptions& o = c.options;
  return fmt::format(
      "{} {} {} {} {} {} {} {} ms", key(c), o.formulation ? static_cast<int>(*o.formulation) : -1,
      o.inertia ? static_cast<int>(*o.inertia) : -1, o.integrator ? static_cast<int>(*o.integrator) : -1,
      o.rho.value_or(-1), o.xi.value_or(1), o.substeps.value_or(0), milliseconds);
}

/// Whole steps only: their errors are compared instant by instant.
RunPlan plan_of(const Simulation& simulation) {
  const double step = simulation.step_size();
  return plan_run(step * std::round(simulation.model().spec().simulation.end / step), 0, step);
}

std::int64_t steps_of(const Simulation& simulation) { return plan_of(simulation).steps; }

/// All steps of a run, `see` called after every `stride` of them. Throws when it fails.
template <class See>
RunTotals run_through(Simulation& simulation, std::int64_t stride, See&& see) {
  RunTotals totals;
  const RunPlan plan = plan_of(simulation);
  while (totals.steps < plan.steps) {
    const std::int64_t until = std::min(totals.steps + stride, plan.steps);
    const StepReport report = advance(simulation, plan, until, totals, interrupted);
    if (interrupted()) throw Failure("interrupted");
    if (!report.ok()) throw std::runtime_error(simulation.explain(report));
    see();
  }
  return totals;
}

}  // namespace

double Lab::Trace::at(double time) const {
  const double place = std::clamp(time / interval, 0.0, static_cast<double>(height.size() - 1));
  const auto k = std::min(static_cast<std::size_t>(place), height.size() - 2);
  const double part = place - static_cast<double>(k);
  return (1 - part) * height[k] + part * height[k + 1];
}

std::shared_ptr<const Model> Lab::model(const Case& c) {
  std::shared_ptr<const Model>& found = models_[key(c)];
  if (!found) found = Model::compile(load_model(examples_.path(c.file), c.settings));
  return found;
}

Counts Lab::counts(const Case& c) {
  const Simulation simulation(model(c), c.options);
  return {simulation.coordinates(), simulation.constraints()};
}

double Lab::cpu_seconds(const Case& c) {
  double least = INFINITY, sum = 0;
  for (int run = 0; run < most_runs && (run < least_runs || sum < enough_seconds) && sum < too_many_seconds;
       ++run) {
    Simulation simulation(model(c), c.options);
    const double seconds = run_through(simulation, steps_of(simulation), [] {}).cpu_seconds;
    least = std::min(least, seconds);
    sum += seconds;
  }
  return least;
}

Lab::Trace Lab::heights(const Case& c, int stride) {
  Simulation simulation(model(c), c.options);
  const auto& channels = simulation.channels();
  const auto found = std::find_if(channels.begin(), channels.end(),
                                  [](const ChannelInfo& channel) { return channel.name == "chassis.z"; });
  const auto channel = found - channels.begin();
  Trace trace{stride * simulation.step_size(), {}};
  ResultsRow row;
  const auto see = [&] {
    simulation.sample(row);
    trace.height.push_back(row.channels[channel]);
  };
  see();
  run_through(simulation, stride, see);
  return trace;
}

const Lab::Trace& Lab::reference(const Case& c) {
  const auto found = references_.find(key(c));
  if (found != references_.end()) return found->second;
  Case fine{c.file, c.settings, {}};
  fine.options.step = reference_step;
  return references_[key(c)] = heights(fine, 10);
}

double Lab::height_error(const Case& c) {
  const Trace& exact = reference(c);
  const Trace trace = heights(c, 1);
  const double end = model(c)->spec().simulation.end;
  double sum = 0;
  int count = 0;
  for (std::size_t k = 0; k < trace.height.size(); ++k) {
    const double time = static_cast<double>(k) * trace.interval;
    if (time < end - compared_seconds - 1e-9) continue;
    sum += std::abs(trace.height[k] - exact.at(time));
    ++count;
  }
  return sum / count;
}

Eigen::MatrixXd Lab::tips(const Case& c, int stride) {
  Simulation simulation(model(c), c.options);
  Eigen::MatrixXd history(simulation.output_count(), steps_of(simulation) / stride);
  ResultsRow row;
  Eigen::Index k = 0;
  run_through(simulation, stride, [&] {
    simulation.sample(row);
    if (k < history.cols()) history.col(k++) = row.channels.head(history.rows());
  });
  return history;
}

Eigen::VectorXd Lab::tip_deviation(const Case& c) {
  Eigen::MatrixXd& exact = tip_references_[c.file];
  if (exact.size() == 0) {
    Case fine{c.file, {{"method", "nonlinear_beam"}, {"elements", "40"}}, {}};
    fine.options.step = tip_reference_step;
    exact = tips(fine, static_cast<int>(std::lround(tip_interval / tip_reference_step)));
  }
  const Eigen::MatrixXd history = tips(c, static_cast<int>(std::lround(tip_interval / *c.options.step)));
  return (history - exact).cwiseAbs().rowwise().mean();
}

std::optional<double> Lab::error_at(const Case& c, int milliseconds) {
  const auto [found, fresh] = errors_.try_emplace(key(c, milliseconds));
  if (!fresh) return found->second;
  Case stepped = c;
  stepped.options.step = 1e-3 * milliseconds;
  reference(c);  // what fails in it is no fault of the step
  try {
    found->second = height_error(stepped);
  } catch (const Failure&) {
    throw;
  } catch (const std::runtime_error&) {
  }
  return found->second;
}

LongestStep Lab::longest_step(const Case& c) {
  for (int ms = longest_milliseconds; ms >= shortest_milliseconds; --ms)
    if (const auto error = error_at(c, ms)) return {1e-3 * ms, *error};
  throw std::runtime_error(fmt::format("no step of {} ms or more goes through", shortest_milliseconds));
}

double Lab::unbroken_step(const Case& c) {
  int ms = shortest_milliseconds - 1;
  while (ms < longest_milliseconds && error_at(c, ms + 1)) ++ms;
  if (ms < shortest_milliseconds)
    throw std::runtime_error(fmt::format("a step of {} ms does not go through", shortest_milliseconds));
  return 1e-3 * ms;
}

double Lab::mean_energy_loss(const Case& c) {
  Simulation simulation(model(c), c.options);
  double sum = 0;
  const RunTotals totals =
      run_through(simulation, 1, [&] { sum += std::abs(simulation.energy().numerical); });
  return sum / static_cast<double>(totals.steps);
}

double Lab::energy_loss(const Case& c) {
  Simulation simulation(model(c), c.options);
  run_through(simulation, steps_of(simulation), [] {});
  return -simulation.energy().numerical;
}

}  // namespace mimbre::app
