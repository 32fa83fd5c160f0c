#include "mimbre/real_time_recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "live/mailbox.h"
#include "mimbre/results.h"

namespace mimbre {
namespace {

/// A row, and whether the simulation was put elsewhere before it.
struct Waiting {
  ResultsRow row;
  bool anew = false;
};

constexpr std::size_t waiting_rows = 256, waiting_timings = 1 << 15;
/// Single steps are kept up to here; of what comes after, see the attributes.
constexpr std::size_t most_timings = 10'000'000;
constexpr auto look_again = std::chrono::milliseconds(10);

/// "drive.h5" → "drive-2.h5".
std::string numbered(const std::string& path, int number) {
  if (number == 1) return path;
  const std::filesystem::path given(path);
  return (given.parent_path() /
          fmt::format("{}-{}{}", given.stem().string(), number, given.extension().string()))
      .string();
}

}  // namespace

struct RealTimeRecorder::Impl {
  Impl(const std::string& asked, Simulation& simulation, const std::string& options_json, double interval)
      : path(asked),
        header(simulation.header(options_json)),
        every(std::max<std::int64_t>(std::llround(interval / simulation.step_size()), 1)) {
    ResultsRow row;
    simulation.sample(row);
    rows = std::make_unique<live::Queue<Waiting>>(waiting_rows, Waiting{row});
    open();
    add({row, false});
    thread = std::thread([this] { work(); });
  }

  ~Impl() { stop(); }

  void open() {
    std::error_code none;
    do ++files;
    while (files > 1 && std::filesystem::exists(numbered(path, files), none));
    writer = std::make_unique<ResultsWriter>(numbered(path, files), header);
    const std::lock_guard<std::mutex> lock(message_mutex);
    current = numbered(path, files);
  }

  void add(const Waiting& waiting) {
    if (waiting.anew && last > -std::numeric_limits<double>::infinity()) {
      writer->finish("");
      open();
      last = -std::numeric_limits<double>::infinity();
    }
    if (waiting.row.time <= last) return;
    last = waiting.row.time;
    writer->add(waiting.row);
  }

  void work() {
    for (bool ends = false; !ends;) {
      ends = stopping.load(std::memory_order_acquire);
      try {
        drain();
      } catch (const std::exception& error) {
        const std::lock_guard<std::mutex> lock(message_mutex);
        failure = error.what();
        failed = true;
        return;
      }
      if (!ends) std::this_thread::sleep_for(look_again);
    }
  }

  void drain() {
    while (const Waiting* row = rows->front()) {
      add(*row);
      rows->pop();
    }
    while (const StepTiming* t = timings.front()) {
      if (computation.size() < most_timings) {
        computation.push_back(static_cast<float>(t->computation));
        latency.push_back(static_cast<float>(t->latency));
        cpu.push_back(static_cast<float>(t->cpu));
        iterations.push_back(static_cast<float>(t->iterations));
      }
      timings.pop();
    }
    writer->flush_if_due();
  }

  void stop() {
    stopping.store(true, std::memory_order_release);
    if (thread.joinable()) thread.join();
  }

  const std::string path;
  const ResultsHeader header;
  const std::int64_t every;  ///< steps
  std::unique_ptr<ResultsWriter> writer;
  int files = 0;
  double last = -std::numeric_limits<double>::infinity();
  std::vector<float> computation, latency, cpu, iterations;

  std::unique_ptr<live::Queue<Waiting>> rows;
  live::Queue<StepTiming> timings{waiting_timings};
  std::int64_t steps = 0;
  bool anew = false;  ///< of the loop's thread
  std::atomic<bool> on{true}, stopping{false}, failed{false};
  std::atomic<std::int64_t> lost{0};

  mutable std::mutex message_mutex;  ///< of the loop's thread never
  std::string failure, current;
  std::thread thread;
};

RealTimeRecorder::RealTimeRecorder(const std::string& path, Simulation& simulation,
                                   const std::string& options_json, double interval)
    : impl_(std::make_unique<Impl>(path, simulation, options_json, interval)) {}
RealTimeRecorder::~RealTimeRecorder() = default;

void RealTimeRecorder::after(Simulation& simulation, const StepReport& report, bool output) {
  Impl& s = *impl_;
  if (!report.ok() || ++s.steps % s.every != 0 || !output || !s.on.load(std::memory_order_relaxed)) return;
  if (Waiting* const waiting = s.rows->place()) {
    simulation.sample(waiting->row);
    waiting->anew = s.anew;
    s.anew = false;
    s.rows->push();
  } else {
    s.lost.store(s.lost.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }
}

void RealTimeRecorder::moved(Simulation&) { impl_->anew = true; }

void RealTimeRecorder::timed(const StepTiming& timing) { impl_->timings.push(timing); }

void RealTimeRecorder::record(bool on) { impl_->on = on; }
bool RealTimeRecorder::recording() const { return impl_->on && !impl_->failed; }
std::int64_t RealTimeRecorder::lost_rows() const { return impl_->lost; }
std::string RealTimeRecorder::failure() const {
  const std::lock_guard<std::mutex> lock(impl_->message_mutex);
  return impl_->failure;
}
std::string RealTimeRecorder::path() const {
  const std::lock_guard<std::mutex> lock(impl_->message_mutex);
  return impl_->current;
}

void RealTimeRecorder::finish(const RealTimeLoop& loop, const std::string& summary_json) {
  Impl& s = *impl_;
  s.stop();
  if (s.failed) throw std::runtime_error(s.failure);
  const RealTimeMonitor& m = loop.monitor();
  ResultsWriter::Group group;
  group.name = "realtime";
  const auto write_timings = [&](const std::string& of, const Timings& timings) {
    group.attributes.emplace_back(of + "_median", timings.quantile(0.5));
    group.attributes.emplace_back(of + "_p99", timings.quantile(0.99));
    group.attributes.emplace_back(of + "_p9999", timings.quantile(0.9999));
    group.attributes.emplace_back(of + "_worst", timings.worst());
  };
  write_timings("computation", m.computation);
  write_timings("cpu", m.cpu);
  write_timings("latency", m.latency);
  group.attributes.emplace_back("step", loop.step());
  group.attributes.emplace_back("speed", loop.options().speed);
  group.attributes.emplace_back("steps", static_cast<double>(m.steps));
  group.attributes.emplace_back("overruns", static_cast<double>(m.overrun_count()));
  for (int k = 0; k < overrun_causes; ++k)
    group.attributes.emplace_back(std::string("overruns_") + name_of(static_cast<OverrunCause>(k)),
                                  static_cast<double>(m.overruns[static_cast<std::size_t>(k)]));
  group.attributes.emplace_back("late_steps", static_cast<double>(m.late));
  group.attributes.emplace_back("lost_rows", static_cast<double>(s.lost));
  const RealTimeGrants granted = loop.granted();
  group.texts = {{"memory", granted.memory},
                 {"scheduling", granted.scheduling},
                 {"processor", granted.processor},
                 {"worst_case", loop.worst_case()}};
  group.columns = {{"computation", std::move(s.computation)},
                   {"latency", std::move(s.latency)},
                   {"cpu", std::move(s.cpu)},
                   {"iterations", std::move(s.iterations)}};
  s.writer->add_group(std::move(group));
  s.writer->finish(summary_json);
}

}  // namespace mimbre
