#include "mimbre/real_time.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "live/host.h"
#include "live/mailbox.h"
#include "mimbre/diagnostics.h"

namespace mimbre {
namespace {

constexpr double nano = 1e-9;
constexpr std::int64_t resting = 5'000'000;  ///< ns between two looks at what is asked for
constexpr int rehearsed_steps = 8;
constexpr int usual_after = 64;  ///< steps, from which on is known what is usual
/// CPU time over what the iterations explain, from which on it was not the step's.
constexpr double unexplained = 4;

std::int64_t to_nanoseconds(double seconds) { return std::llround(seconds / nano); }

void require(bool right, const std::string& message) {
  if (!right) throw InputError(Mark{}, message);
}

void check(const RealTimeOptions& o) {
  require(o.speed >= 1e-6 && o.speed <= 1e6,
          fmt::format("the speed against the clock is {}; it must be 1e-6 to 1e6", o.speed));
  require(o.duration > 0, fmt::format("the duration is {} s; it must be positive", o.duration));
  require(o.priority >= 0 && o.priority <= 99,
          fmt::format("the priority is {}; it must be 1 to 99, or 0 for none", o.priority));
  require(o.spin >= 0 && o.spin < 1, fmt::format("spinning is {} s; it must be 0 to 1 s", o.spin));
  require(o.snapshots >= 0 && o.snapshots <= 1000,
          fmt::format("there are {} places for snapshots; there must be 0 to 1000", o.snapshots));
}

using live::increase;

/// Of the only thread that changes it.
template <class Number>
void raise(std::atomic<Number>& number, Number to) {
  if (to > number.load(std::memory_order_relaxed)) number.store(to, std::memory_order_relaxed);
}

void wait_until(std::int64_t due, double spin) {
  live::sleep_until(due - to_nanoseconds(spin));
  while (live::clock_now() < due) {
  }
}

/// What took the largest part of a delay. `usual`: CPU seconds of a step, and iterations; 0: not known yet.
OverrunCause cause_of(const StepTiming& t, double usual, double usual_iterations) {
  const double waited = t.computation - t.cpu, more = usual > 0 ? t.cpu - usual : t.cpu;
  if (t.latency >= std::max(waited, more)) return OverrunCause::latency;
  if (waited >= more) return OverrunCause::preemption;
  // What interrupts take, and what a virtual machine's host does, is in the thread's CPU time too.
  const double explained = usual * (t.iterations + 1) / (usual_iterations + 1);
  if (usual > 0 && t.parts == 1 && t.page_faults == 0 && t.cpu > unexplained * explained)
    return OverrunCause::preemption;
  if (t.parts > 1) return OverrunCause::parts;
  if (t.page_faults > 0) return OverrunCause::page_faults;
  if (usual_iterations > 0 && t.iterations > usual_iterations + 1) return OverrunCause::iterations;
  return OverrunCause::computation;
}

/// Waits for a step that is due then, and returns how it begins; `done`: when the one before was.
StepTiming begun(std::int64_t step, std::int64_t due, std::int64_t done, double spin) {
  wait_until(due, spin);
  StepTiming timing;
  timing.step = step;
  timing.behind = nano * static_cast<double>(std::max<std::int64_t>(done - due, 0));
  timing.latency = nano * static_cast<double>(live::clock_now() - std::max(due, done));
  return timing;
}

/// Measures what is done between two calls, in the calling thread: CPU time within the clock's, so that what
/// happens between two readings is not taken for work.
class Measured {
 public:
  Measured() : begin_(live::clock_now()), usage_(live::thread_usage()), cpu_(live::thread_cpu_now()) {}
  /// Returns when it ended.
  std::int64_t end(StepTiming& timing) const {
    timing.cpu = nano * static_cast<double>(live::thread_cpu_now() - cpu_);
    const live::ThreadUsage usage = live::thread_usage();
    const std::int64_t end = live::clock_now();
    timing.computation = nano * static_cast<double>(end - begin_);
    timing.page_faults = usage.page_faults - usage_.page_faults;
    timing.preemptions = usage.preemptions - usage_.preemptions;
    return end;
  }

 private:
  std::int64_t begin_;
  live::ThreadUsage usage_;
  std::int64_t cpu_;
};

void note(const StepTiming& t, RealTimeMonitor& monitor) {
  const double usual = monitor.steps > usual_after ? monitor.cpu.mean() : 0;
  const double usual_iterations =
      usual > 0 ? static_cast<double>(monitor.iterations) / static_cast<double>(monitor.steps) : 0;
  if (t.overrun)
    increase<std::int64_t>(monitor.overruns[static_cast<std::size_t>(cause_of(t, usual, usual_iterations))],
                           1);
  if (t.behind > 0) increase<std::int64_t>(monitor.late, 1);
  monitor.computation.add(t.computation);
  monitor.cpu.add(t.cpu);
  monitor.latency.add(t.latency);
  increase<std::int64_t>(monitor.iterations, t.iterations);
  if (t.unconverged) increase<std::int64_t>(monitor.unconverged, 1);
  increase<std::int64_t>(monitor.page_faults, t.page_faults);
  increase<std::int64_t>(monitor.preemptions, t.preemptions);
  raise(monitor.most_iterations, t.iterations);
  raise(monitor.most_parts, t.parts);
  increase<std::int64_t>(monitor.steps, 1);
}

}  // namespace

const char* name_of(OverrunCause cause) {
  static constexpr const char* names[overrun_causes] = {"latency", "preemption", "page_faults",
                                                        "parts",   "iterations", "computation"};
  return names[static_cast<std::size_t>(cause)];
}

std::int64_t RealTimeMonitor::overrun_count() const {
  std::int64_t count = 0;
  for (const auto& of_cause : overruns) count += of_cause.load(std::memory_order_relaxed);
  return count;
}

void RealTimeMonitor::add(const RealTimeMonitor& o) {
  computation.add(o.computation);
  cpu.add(o.cpu);
  latency.add(o.latency);
  for (std::size_t k = 0; k < overruns.size(); ++k) increase<std::int64_t>(overruns[k], o.overruns[k]);
  increase<std::int64_t>(steps, o.steps);
  increase<std::int64_t>(late, o.late);
  increase<std::int64_t>(skipped_outputs, o.skipped_outputs);
  increase<std::int64_t>(iterations, o.iterations);
  increase<std::int64_t>(unconverged, o.unconverged);
  increase<std::int64_t>(page_faults, o.page_faults);
  increase<std::int64_t>(preemptions, o.preemptions);
  increase<double>(lag, o.lag);
  raise<int>(most_iterations, o.most_iterations);
  raise<int>(most_parts, o.most_parts);
}

namespace {

/// What bounds the work of a step, for people.
std::string worst_case_of(const Simulation& s) {
  const int attempts = s.most_attempts(), iterations = s.method().max_iterations;
  const std::string each = fmt::format("at most {} iterations", iterations);
  const std::string tries =
      attempts == 1 ? each + " in a step"
                    : fmt::format("{} in each of at most {} attempts at a step or its parts", each, attempts);
  return s.events().empty() ? tries : tries + "; events are searched for in up to 80 further ones each";
}

}  // namespace

struct RealTimeLoop::Impl {
  Impl(Simulation& s, const RealTimeOptions& o) : simulation(s), options(o), period(s.step_size() / o.speed) {
    check(o);
    beginning = simulation.save();
    saved.assign(static_cast<std::size_t>(o.snapshots), beginning);
    is_saved.assign(saved.size(), false);
    time = simulation.time();
    const double count = std::round(o.duration / simulation.step_size());
    most_steps = count < 9e18 ? std::max<std::int64_t>(static_cast<std::int64_t>(count), 1)
                              : std::numeric_limits<std::int64_t>::max();
  }

  std::string run() {
    const live::RealTimeThread thread(options.lock_memory, options.priority, options.processor);
    granted = std::make_shared<const RealTimeGrants>(thread.granted());
    rehearse();
    begin_clock();
    while (!stopping.load(std::memory_order_relaxed)) {
      const bool over = state == State::ended || state == State::failed;
      if (over && !options.rests_at_end) break;
      take_requests();
      if (state == State::running || single) {
        step();
      } else {
        rest();
      }
    }
    return why();
  }

  /// Of what failed or ended.
  std::string why() const {
    const State s = state;
    const auto stored = message.load();
    return stored && (s == State::failed || s == State::ended) ? *stored : std::string();
  }

  /// What the first steps need is fetched before they count.
  void rehearse() {
    Simulation::Snapshot before;
    simulation.save(before);
    for (int k = 0; k < rehearsed_steps; ++k) {
      StepTiming timing;
      const Measured measured;
      if (!simulation.step().ok()) break;
      measured.end(timing);
    }
    simulation.restore(before);
  }

  /// Steps count from now.
  void begin_clock() {
    begin = live::clock_now();
    since = 0;
    done = begin;
  }

  std::int64_t due(std::int64_t step) const {
    return begin + to_nanoseconds(static_cast<double>(step) * period);
  }

  /// False where something else is asked for while it waits.
  bool wait(std::int64_t planned) {
    while (planned - live::clock_now() > 2 * resting) {
      rest();
      if (stopping.load(std::memory_order_relaxed) || requests.front()) return false;
    }
    return true;
  }

  void step() {
    if (!wait(due(since))) return;
    single = false;
    StepTiming timing = begun(made, due(since), done, options.spin);
    const Measured measured;
    const bool output = options.overrun != Overrun::skip_output || timing.behind == 0;
    for (RealTimePart* part : parts) part->before(simulation);
    const StepReport report = simulation.step();
    for (RealTimePart* part : parts) part->after(simulation, report, output);
    if (!output) increase<std::int64_t>(monitor.skipped_outputs, 1);
    timing.iterations = report.iterations;
    timing.parts = report.substeps;
    timing.unconverged = report.unconverged;
    done = measured.end(timing);
    timing.overrun = timing.latency + timing.computation > period;
    note(timing, monitor);
    for (RealTimePart* part : parts) part->timed(timing);
    time.store(simulation.time(), std::memory_order_relaxed);
    ++since;
    ++made;

    if (!report.ok())
      end(State::failed, simulation.explain(report));
    else if (simulation.stopped())
      end(State::ended, "an event of the model ended it");
    else if (made >= most_steps)
      end(State::ended, "");
    else if (done > due(since))
      overrun(timing);
  }

  void overrun(const StepTiming& timing) {
    if (options.overrun == Overrun::slow_down) {
      const std::int64_t by = done - due(since);
      begin += by;
      increase(monitor.lag, nano * static_cast<double>(by));
    } else if (options.overrun == Overrun::stop) {
      end(State::failed,
          fmt::format("the step to t = {:.6g} s was not ready in time: it took {:.3g} ms of {:.3g} ms and "
                      "began {:.3g} ms late",
                      simulation.time(), 1e3 * timing.computation, 1e3 * period, 1e3 * timing.latency));
    }
  }

  void end(State how, const std::string& why) {
    message = std::make_shared<const std::string>(why);
    state = how;
  }

  void rest() {
    live::sleep_until(live::clock_now() + resting);
    for (RealTimePart* part : parts) part->rests(simulation);
  }

  void take_requests() {
    using Kind = RealTimeRequest::Kind;
    while (const RealTimeRequest* request = requests.front()) {
      const auto place = static_cast<std::size_t>(request->place);
      switch (request->kind) {
        case Kind::pause:
          if (state == State::running) state = State::paused;
          break;
        case Kind::resume:
          if (state == State::paused) go_on();
          break;
        case Kind::step:
          if (state == State::paused) {
            begin_clock();
            single = true;
            requests.pop();
            return;  // what else is asked for comes after it
          }
          break;
        case Kind::reset:
          put_to(beginning);
          break;
        case Kind::save:
          if (place < saved.size()) {
            simulation.save(saved[place]);
            is_saved[place] = true;
          }
          break;
        case Kind::restore:
          if (place < saved.size() && is_saved[place]) put_to(saved[place]);
          break;
      }
      requests.pop();
    }
  }

  void go_on() {
    begin_clock();
    state = State::running;
  }

  /// A loop that was at its end goes on from there.
  void put_to(const Simulation::Snapshot& snapshot) {
    simulation.restore(snapshot);
    if (state == State::ended || state == State::failed) made = 0;
    message.store({});
    if (state != State::paused) go_on();
    time.store(simulation.time(), std::memory_order_relaxed);
    for (RealTimePart* part : parts) part->moved(simulation);
  }

  Simulation& simulation;
  const std::string worst_case = worst_case_of(simulation);
  const std::string not_saved = simulation.not_saved();
  const RealTimeOptions options;
  const double period;  ///< s of the clock
  std::int64_t most_steps = 0;
  std::vector<RealTimePart*> parts;
  Simulation::Snapshot beginning;
  std::vector<Simulation::Snapshot> saved;
  std::vector<bool> is_saved;

  std::int64_t begin = 0;  ///< ns of the clock
  std::int64_t since = 0;  ///< steps since then
  std::int64_t done = 0;   ///< ns, when the last step was
  std::int64_t made = 0;   ///< steps
  bool single = false;

  live::Queue<RealTimeRequest> requests{256};
  std::atomic<bool> stopping{false};
  std::atomic<State> state{State::running};
  std::atomic<double> time{0};
  std::atomic<std::shared_ptr<const std::string>> message;  ///< set once at an end
  std::atomic<std::shared_ptr<const RealTimeGrants>> granted;
  RealTimeMonitor monitor;
};

RealTimeLoop::RealTimeLoop(Simulation& simulation, const RealTimeOptions& options)
    : impl_(std::make_unique<Impl>(simulation, options)) {}
RealTimeLoop::~RealTimeLoop() = default;

void RealTimeLoop::add(RealTimePart& part) { impl_->parts.push_back(&part); }
std::string RealTimeLoop::run() { return impl_->run(); }
void RealTimeLoop::stop() { impl_->stopping = true; }
bool RealTimeLoop::request(const RealTimeRequest& request) {
  using Kind = RealTimeRequest::Kind;
  const bool of_place = request.kind == Kind::save || request.kind == Kind::restore;
  if (of_place && (request.place < 0 || request.place >= impl_->options.snapshots))
    throw std::out_of_range(fmt::format("request: there is no place {}; they are counted from 0 to {}",
                                        request.place, impl_->options.snapshots - 1));
  if (of_place && !impl_->not_saved.empty()) throw InputError(Mark{}, impl_->not_saved);
  return impl_->requests.push(request);
}
RealTimeLoop::State RealTimeLoop::state() const { return impl_->state; }
double RealTimeLoop::time() const { return impl_->time.load(std::memory_order_relaxed); }
const RealTimeMonitor& RealTimeLoop::monitor() const { return impl_->monitor; }
const RealTimeOptions& RealTimeLoop::options() const { return impl_->options; }
double RealTimeLoop::step() const { return impl_->simulation.step_size(); }

std::string RealTimeLoop::message() const { return impl_->why(); }

RealTimeGrants RealTimeLoop::granted() const {
  const auto granted = impl_->granted.load();
  return granted ? *granted : RealTimeGrants();
}

std::string RealTimeLoop::worst_case() const { return impl_->worst_case; }

void idle_loop(double step, double duration, const RealTimeOptions& options, RealTimeMonitor& monitor) {
  check(options);
  require(std::isfinite(step) && step > 0, fmt::format("the step is {} s; it must be positive", step));
  const live::RealTimeThread thread(options.lock_memory, options.priority, options.processor);
  const std::int64_t begin = live::clock_now();
  std::int64_t done = begin;
  for (std::int64_t k = 0; static_cast<double>(k) * step < duration; ++k) {
    StepTiming timing = begun(k, begin + to_nanoseconds(static_cast<double>(k) * step), done, options.spin);
    const Measured measured;
    done = measured.end(timing);
    timing.overrun = timing.latency + timing.computation > step;
    note(timing, monitor);
  }
}

}  // namespace mimbre
