#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "mimbre/simulation.h"
#include "mimbre/timings.h"

/// Steps of a simulation that begin at given times of the clock.
namespace mimbre {

/// What is done when a step was not ready when the next one was due.
enum class Overrun {
  catch_up,     ///< the next ones begin at once, until the clock is caught up with
  skip_output,  ///< the same, and until then pictures and rows are left out
  slow_down,    ///< the clock is set back: the simulation lags behind for good
  stop          ///< the loop ends
};

struct RealTimeOptions {
  double speed = 1;                                           ///< simulated seconds in one of the clock, > 0
  double duration = std::numeric_limits<double>::infinity();  ///< s, simulated
  Overrun overrun = Overrun::catch_up;
  bool lock_memory = true;  ///< all memory of the process stays in place, where that is permitted
  int priority = 0;         ///< 1 to 99: of SCHED_FIFO, where that is permitted; 0: as other programs
  int processor = -1;       ///< the loop's thread stays on it; -1: any
  double spin = 0;          ///< s before a step is due in which its thread waits without sleeping
  /// Where its time is over, or a step failed, the loop rests until it is asked to stop, to be reset or put
  /// elsewhere; otherwise run() returns.
  bool rests_at_end = false;
  int snapshots = 16;  ///< places for RealTimeRequest::save and restore
};

/// Why a step was not ready in time: what took the largest part of its delay.
enum class OverrunCause {
  latency,      ///< its thread was woken too late
  preemption,   ///< its thread was taken from the processor, or waited for it, or was charged with what its
                ///< iterations do not explain: interrupts, a virtual machine's host
  page_faults,  ///< memory had to be fetched
  parts,        ///< the step was made in parts
  iterations,   ///< it took more iterations than usual
  computation   ///< it takes that long
};
constexpr int overrun_causes = 6;
/// "latency", "preemption", …
const char* name_of(OverrunCause cause);

/// How a step went against the clock. Times in s.
struct StepTiming {
  std::int64_t step = 0;   ///< counted from 0
  double latency = 0;      ///< from when it could have begun (due, and the one before done) until it did
  double behind = 0;       ///< how long after it was due the step before it was done
  double computation = 0;  ///< by the clock, of everything done for it
  double cpu = 0;          ///< that its thread worked for it
  int iterations = 0, parts = 1;
  bool unconverged = false;  ///< RunOptions::fixed_cost
  std::int64_t page_faults = 0, preemptions = 0;
  bool overrun = false;  ///< it was not ready when the next one was due, though it could begin in time
};

/// What is known of all steps so far. The loop's thread writes; others may read meanwhile.
struct RealTimeMonitor {
  Timings computation, cpu, latency;
  std::array<std::atomic<std::int64_t>, overrun_causes> overruns{};
  std::atomic<std::int64_t> steps{0};
  std::atomic<std::int64_t> late{0};             ///< began after they were due, for overruns before them
  std::atomic<std::int64_t> skipped_outputs{0};  ///< left out by Overrun::skip_output
  std::atomic<std::int64_t> iterations{0};       ///< of all steps
  std::atomic<std::int64_t> unconverged{0};      ///< steps, of RunOptions::fixed_cost
  std::atomic<int> most_iterations{0}, most_parts{1};
  std::atomic<std::int64_t> page_faults{0}, preemptions{0};
  std::atomic<double> lag{0};  ///< s, by which the clock was set back (Overrun::slow_down)
  std::int64_t overrun_count() const;
  /// What another has seen, too.
  void add(const RealTimeMonitor& other);
};

/// What the system granted to the loop's thread, for people: "locked"; "not locked: Operation not permitted
/// (…)".
struct RealTimeGrants {
  std::string memory, scheduling, processor;
};

/// What takes part in every step, in the loop's thread: exchange of inputs and outputs, recording. It must
/// not block, allocate or throw.
class RealTimePart {
 public:
  virtual ~RealTimePart() = default;
  /// Before a step, in its time.
  virtual void before(Simulation&) {}
  /// After it, in its time, too. `output`: not to be left out (Overrun::skip_output).
  virtual void after(Simulation&, const StepReport&, bool /*output*/) {}
  /// How it went, when it is over.
  virtual void timed(const StepTiming&) {}
  /// Now and then while no steps are made.
  virtual void rests(Simulation&) {}
  /// The simulation was put elsewhere: reset, or returned to a snapshot.
  virtual void moved(Simulation&) {}
};

/// What another thread asks of the loop, between two steps.
struct RealTimeRequest {
  enum class Kind {
    pause,
    resume,
    step,    ///< one, while it is paused
    reset,   ///< to where it began
    save,    ///< into the place
    restore  ///< from the place, where something was saved
  } kind = Kind::pause;
  int place = 0;
};

/// Steps a simulation against an absolute clock: step k is due `k · step / speed` after the beginning,
/// whatever the ones before it took.
class RealTimeLoop {
 public:
  enum class State { running, paused, ended, failed };

  /// Throws InputError for options that cannot be. The simulation must outlive it, and is of the loop's
  /// thread alone while run() runs.
  RealTimeLoop(Simulation& simulation, const RealTimeOptions& options);
  ~RealTimeLoop();
  RealTimeLoop(const RealTimeLoop&) = delete;
  RealTimeLoop& operator=(const RealTimeLoop&) = delete;

  /// Takes part from then on; it must outlive run().
  void add(RealTimePart& part);

  /// Steps until the time is over, an event of the model stops it, a step fails, an overrun stops it or
  /// stop() is called. Before the first one it requests from the system what the options need, and makes a
  /// few steps to bring all memory that they need into place, which are taken back. Nothing in the loop
  /// allocates. Returns why it ended; empty: its time was over, or stop().
  std::string run();

  // The rest is for any thread, at any time, without locks.
  void stop();
  /// False where too many are waiting. One thread may ask. Throws std::out_of_range where there is no such
  /// place.
  bool request(const RealTimeRequest& request);
  State state() const;
  /// Why it failed or ended; only while state() is one of these. Empty: its time was over.
  std::string message() const;
  /// s, of the simulation.
  double time() const;
  const RealTimeMonitor& monitor() const;
  /// Empty before run().
  RealTimeGrants granted() const;
  /// What bounds the work of a step, for people.
  std::string worst_case() const;
  const RealTimeOptions& options() const;
  double step() const;  ///< s

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// What the machine itself does: a loop that only waits and reads the clocks, each `step` for `duration` s.
/// Its latencies and computations are those of the machine and not of a simulation.
void idle_loop(double step, double duration, const RealTimeOptions& options, RealTimeMonitor& monitor);

}  // namespace mimbre
