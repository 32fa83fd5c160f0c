#include "mimbre/real_time_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <tuple>

#include "live/host.h"
#include "live/lowest_modes.h"
#include "mimbre/diagnostics.h"
#include "mimbre/method_names.h"
#include "spec/output_kind.h"

namespace mimbre {
namespace {

using Formulation = spec::Simulation::Formulation;

constexpr int fine = 16;  ///< steps of the fine run in a deadline
constexpr int most_fine_iterations = 30;
constexpr double longest_idle = 2;  ///< s, for which the idle machine is watched
/// More iterations than were seen are allowed for what was not.
constexpr int spare_iterations = 2;
/// An output that moves less than this share of what it is stands still.
constexpr double still = 1e-9;
/// What moves less than this share of the others of its unit is judged as if it moved so much.
constexpr double least_share = 0.01;

/// What of a run is compared: the model's outputs, or where it has none the places of its bodies.
struct History {
  std::vector<std::string> names, units;
  std::vector<std::vector<double>> values;  ///< by instant
};

History named(const Simulation& simulation) {
  History history;
  for (int k = 0; k < simulation.output_count(); ++k) {
    const ChannelInfo& channel = simulation.channels()[static_cast<std::size_t>(k)];
    history.names.push_back(channel.name);
    history.units.push_back(channel.unit);
  }
  if (history.names.empty())
    for (const spec::Body& body : simulation.model().spec().bodies)
      for (const char* axis : {".x", ".y", ".z"}) {
        history.names.push_back(body.name + axis);
        history.units.push_back("m");
      }
  return history;
}

std::vector<double> seen_in(Simulation& simulation) {
  std::vector<double> values;
  for (int k = 0; k < simulation.output_count(); ++k) values.push_back(simulation.value({k}));
  if (values.empty())
    for (std::size_t k = 0; k < simulation.model().spec().bodies.size(); ++k)
      for (const double place : simulation.pose({static_cast<int>(k)}).position) values.push_back(place);
  return values;
}

/// Steps as fast as they come, with an instant of history for each deadline.
History history_of(Simulation& simulation, const RealTimePlanOptions& o, double end, Timings* timings,
                   int* most_iterations) {
  const double instant = o.deadline * o.loop.speed;
  const auto per_deadline = std::max<std::int64_t>(std::llround(instant / simulation.step_size()), 1);
  const auto instants = std::max<std::int64_t>(std::llround(end / instant), 1);
  History history = named(simulation);
  history.values.push_back(seen_in(simulation));
  for (std::int64_t k = 0; k < instants && !simulation.stopped(); ++k) {
    for (std::int64_t step = 0; step < per_deadline && !simulation.stopped(); ++step) {
      if (o.drive) o.drive(simulation);
      const std::int64_t begin = live::thread_cpu_now();
      const StepReport report = simulation.step();
      if (timings) timings->add(1e-9 * static_cast<double>(live::thread_cpu_now() - begin));
      if (!report.ok()) throw std::runtime_error(simulation.explain(report));
      if (most_iterations) *most_iterations = std::max(*most_iterations, report.iterations);
    }
    history.values.push_back(seen_in(simulation));
  }
  return history;
}

/// By how much each output moves; 0: it stands still.
std::vector<double> ranges_of(const History& history) {
  std::vector<double> ranges;
  for (std::size_t k = 0; k < history.names.size(); ++k) {
    double low = INFINITY, high = -INFINITY;
    for (const std::vector<double>& instant : history.values) {
      low = std::min(low, instant[k]);
      high = std::max(high, instant[k]);
    }
    const bool moves = high - low > still * std::max(std::abs(low), std::abs(high));
    ranges.push_back(moves ? high - low : 0);
  }
  std::vector<double> judged = ranges;
  for (std::size_t k = 0; k < ranges.size(); ++k)
    for (std::size_t other = 0; other < ranges.size(); ++other)
      if (ranges[k] > 0 && history.units[k] == history.units[other])
        judged[k] = std::max(judged[k], least_share * ranges[other]);
  return judged;
}

/// The largest error of all outputs that both have.
void judge(const History& exact, const std::vector<double>& ranges, const History& history,
           RealTimeCandidate& candidate) {
  if (history.values.size() != exact.values.size())
    candidate.error = INFINITY;  // an event ended it elsewhere
  const std::size_t instants = std::min(exact.values.size(), history.values.size());
  for (std::size_t k = 0; k < exact.names.size(); ++k) {
    const auto found = std::find(history.names.begin(), history.names.end(), exact.names[k]);
    if (found == history.names.end() || ranges[k] == 0) continue;
    const auto column = static_cast<std::size_t>(found - history.names.begin());
    double squares = 0;
    for (std::size_t i = 0; i < instants; ++i)
      squares += std::pow(history.values[i][column] - exact.values[i][k], 2);
    const double error = std::sqrt(squares / static_cast<double>(instants)) / ranges[k];
    if (error > candidate.error || std::isnan(error)) {
      candidate.error = error;
      candidate.worst_output = exact.names[k];
    }
  }
}

RunOptions options_of(const RealTimePlanOptions& o, const RealTimeCandidate& c) {
  RunOptions run = o.run;
  run.formulation = c.formulation;
  run.step = c.step;
  run.substeps.reset();
  if (c.substeps > 0) run.substeps = c.substeps;
  run.max_iterations.reset();
  if (c.max_iterations > 0) {
    run.max_iterations = c.max_iterations;
    run.fixed_cost = c.fixed_cost;
  }
  return run;
}

/// 99.99 % of computation and latency, over the step's time.
double load_of(const RealTimeMonitor& monitor, double period) {
  return (monitor.computation.quantile(0.9999) + monitor.latency.quantile(0.9999)) / period;
}

/// Over and over for the time that is asked for.
std::shared_ptr<RealTimeMonitor> watch(const std::shared_ptr<const Model>& model,
                                       const RealTimePlanOptions& o, const RealTimeCandidate& c, double end,
                                       std::string& failure) {
  struct Again : RealTimePart {
    const RealTimePlanOptions* options = nullptr;
    RealTimeLoop* loop = nullptr;
    double end = 0;
    std::int64_t left = 0;
    bool asked = false;
    void before(Simulation& simulation) override {
      if (options->drive) options->drive(simulation);
    }
    void after(Simulation& simulation, const StepReport& report, bool) override {
      if (--left <= 0 || !report.ok()) loop->stop();
      if (asked || (simulation.time() < end && !simulation.stopped())) return;
      asked = loop->request({RealTimeRequest::Kind::reset});
    }
    void moved(Simulation&) override { asked = false; }
  } again;
  Simulation simulation(model, options_of(o, c));
  RealTimeOptions of_loop = o.loop;
  // An event that ends the manoeuvre is the end of one of many.
  of_loop.rests_at_end = true;
  again.left = std::llround(o.watch * of_loop.speed / c.step);
  // The loop and its monitor go; what was measured stays.
  auto loop = std::make_shared<RealTimeLoop>(simulation, of_loop);
  again.options = &o;
  again.loop = loop.get();
  again.end = end;
  loop->add(again);
  loop->run();
  failure = loop->state() == RealTimeLoop::State::failed ? loop->message() : std::string();
  auto kept = std::make_shared<RealTimeMonitor>();
  kept->add(loop->monitor());
  return kept;
}

void check(const RealTimePlanOptions& o) {
  const auto require = [](bool right, const std::string& message) {
    if (!right) throw InputError(Mark{}, message);
  };
  require(o.deadline >= 1e-5 && o.deadline <= 10,
          fmt::format("the deadline is {} s; it must be 1e-5 to 10 s", o.deadline));
  require(o.load > 0 && o.load <= 1,
          fmt::format("the load is {}; it must be above 0, and at most 1", o.load));
  require(o.watch > 0, fmt::format("the time against the clock is {} s; it must be positive", o.watch));
}

/// In the order of what is to be tried: the model as it is first, then with fewer modes.
std::vector<RealTimeCandidate> candidates_of(const spec::Model& model, const RealTimePlanOptions& o) {
  int largest = 0;
  for (const spec::Body& body : model.bodies)
    if (body.flexible && is_linear(*body.flexible)) largest = std::max(largest, body.flexible->modes);
  std::vector<int> modes{0};
  for (const int count : o.modes)
    if (count < largest) modes.push_back(count);
  std::vector<Formulation> formulations{Formulation::relative, Formulation::natural};
  if (o.run.formulation) formulations = {*o.run.formulation};
  std::vector<int> substeps{1};
  const int usual = resolve_method(model.simulation, o.run).substeps;
  if (usual > 1) substeps.push_back(usual);
  std::vector<RealTimeCandidate> candidates;
  for (const Formulation formulation : formulations)
    for (const int count : modes)
      for (const int divisor : o.divisors)
        for (const int parts : substeps) {
          RealTimeCandidate c;
          c.formulation = formulation;
          c.step = o.deadline * o.loop.speed / divisor;
          c.most_modes = count;
          c.substeps = parts;
          candidates.push_back(c);
        }
  return candidates;
}

/// The candidate's model: with fewer modes, or as it is.
std::shared_ptr<const Model> model_with(const spec::Model& model,
                                        const std::shared_ptr<const Model>& compiled,
                                        const RealTimeCandidate& c) {
  return c.most_modes > 0 ? Model::compile(with_lowest_modes(model, c.most_modes)) : compiled;
}

/// Runs a candidate without a clock: its error, times and iterations, and whether it is out of the question.
void measure(const std::shared_ptr<const Model>& model, const RealTimePlanOptions& o, double end,
             const History& exact, const std::vector<double>& ranges, RealTimeCandidate& c) {
  Simulation simulation(model, options_of(o, c));
  c.coordinates = simulation.coordinates();
  Timings timings;
  const History history = history_of(simulation, o, end, &timings, &c.most_iterations);
  judge(exact, ranges, history, c);
  c.median = timings.quantile(0.5);
  c.p9999 = timings.quantile(0.9999);
  c.worst = timings.worst();
  c.max_iterations = c.most_iterations + spare_iterations;
  // A situation that the manoeuvre does not contain must neither end a drive nor take longer.
  c.fixed_cost = c.substeps == 1 && o.run.fixed_cost.value_or(true) &&
                 (simulation.method().formalism == spec::Simulation::Formalism::index3 ||
                  simulation.method().formalism == spec::Simulation::Formalism::transfer_matrices);
  if (c.p9999 > o.load * c.step / o.loop.speed)
    c.failure = "too slow";
  else if (!std::isfinite(c.error))
    c.failure = "no finite outputs, or an end at another time";
}

/// Candidates that did not fail. First those that have time left if the machine is `late` by as much as when
/// it was idle; of them the most accurate, and of equally accurate ones the cheapest. If none has time left,
/// first those that lack the least.
std::vector<int> ranked(const std::vector<RealTimeCandidate>& candidates, const RealTimePlanOptions& o,
                        double late) {
  std::vector<int> order;
  for (std::size_t k = 0; k < candidates.size(); ++k)
    if (candidates[k].failure.empty()) order.push_back(static_cast<int>(k));
  const auto rank = [&](int k) {
    const RealTimeCandidate& c = candidates[static_cast<std::size_t>(k)];
    const double excess = (c.p9999 + late) * o.loop.speed / (o.load * c.step);
    return std::make_tuple(std::round(4 * std::log10(std::max(excess, 1.0))),
                           std::round(4 * std::log10(std::max(c.error, 1e-12))), c.p9999);
  };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return rank(a) < rank(b); });
  return order;
}

}  // namespace

RealTimePlan plan_real_time(const spec::Model& model, const RealTimePlanOptions& o) {
  check(o);
  const auto notify = [&](const std::string& stage, double done) {
    if (o.progress) o.progress(stage, done);
  };
  const double end = o.end > 0 ? o.end : resolve_method(model.simulation, o.run).end;
  RealTimePlan plan;
  plan.deadline = o.deadline;
  plan.reference_step = o.deadline * o.loop.speed / fine;
  notify("idle machine", 0);
  plan.idle = std::make_shared<RealTimeMonitor>();
  idle_loop(o.deadline, std::min(longest_idle, o.watch), o.loop, *plan.idle);

  notify("fine run", 0);
  const auto compiled = Model::compile(model);
  RealTimeCandidate exact;
  exact.step = plan.reference_step;
  exact.substeps = 0;
  RunOptions of_fine = options_of(o, exact);
  of_fine.formulation = Formulation::relative;
  // What the others are measured by converges, whatever it costs.
  if (resolve_method(model.simulation, o.run).fixed_cost) {
    of_fine.fixed_cost = false;
    of_fine.max_iterations = most_fine_iterations;
  }
  Simulation finest(compiled, of_fine);
  const History right = history_of(finest, o, end, nullptr, nullptr);

  const std::vector<double> ranges = ranges_of(right);

  plan.candidates = candidates_of(model, o);
  for (std::size_t k = 0; k < plan.candidates.size(); ++k) {
    RealTimeCandidate& c = plan.candidates[k];
    notify(fmt::format("{}, {:.4g} ms{}", name_of(c.formulation), 1e3 * c.step,
                       c.most_modes > 0 ? fmt::format(", {} modes", c.most_modes) : std::string()),
           static_cast<double>(k) / static_cast<double>(plan.candidates.size()));
    try {
      measure(model_with(model, compiled, c), o, end, right, ranges, c);
    } catch (const std::exception& error) {
      c.failure = error.what();
    }
  }

  const std::vector<int> order = ranked(plan.candidates, o, plan.idle->latency.quantile(0.9999));
  for (const int k : order) {
    RealTimeCandidate& c = plan.candidates[static_cast<std::size_t>(k)];
    notify("against the clock",
           static_cast<double>(plan.watched_candidates) / static_cast<double>(order.size()));
    std::string failure;
    const auto monitor = watch(model_with(model, compiled, c), o, c, end, failure);
    ++plan.watched_candidates;
    const double period = c.step / o.loop.speed, load = load_of(*monitor, period);
    if (!failure.empty()) {
      c.failure = failure;
    } else if (load > o.load && monitor->cpu.quantile(0.9999) > o.load * period) {
      c.failure = fmt::format("against the clock it took {:.0f} % of its time", 100 * load);
    } else {
      plan.chosen = k;
      plan.watched = monitor;
      plan.load = load;
      plan.machine_late = load > o.load;
      break;
    }
  }
  return plan;
}

}  // namespace mimbre
