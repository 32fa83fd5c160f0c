#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mimbre/real_time.h"

/// Which method, step and modes a machine can hold in real time.
namespace mimbre {

/// The model with the lowest eigenmodes of each flexible body, `most` at most; bodies whose displacements are
/// not linear in their amplitudes stay as they are. Outputs of amplitudes go, for they would mean others.
spec::Model with_lowest_modes(spec::Model model, int most);

struct RealTimePlanOptions {
  double deadline = 1e-3;  ///< s of the clock, within which each step has to be done
  double end = 0;          ///< s, simulated, of the manoeuvre that is measured; 0: the model's
  /// Share of a step's time that computation and latency may take, in all steps but one of ten thousand.
  double load = 0.7;
  double watch = 20;  ///< s of the clock, for which a candidate is run against it
  /// Most modes of a body that are tried besides all.
  std::vector<int> modes{2, 4, 8};
  /// Steps are the deadline over these.
  std::vector<int> divisors{1, 2, 4};
  RunOptions run;
  RealTimeOptions loop;  ///< priority, processor, …
  /// Called before each step, where given: inputs of the manoeuvre.
  std::function<void(Simulation&)> drive;
  std::function<void(const std::string& stage, double done)> progress;
};

/// A way to compute the model, and what it was measured to do.
struct RealTimeCandidate {
  spec::Simulation::Formulation formulation = spec::Simulation::Formulation::relative;
  double step = 0;     ///< s
  int most_modes = 0;  ///< of a body; 0: all
  int coordinates = 0;
  int max_iterations = 0, substeps = 1;
  bool fixed_cost = false;  ///< what it is to be run with; see RunOptions::fixed_cost
  /// Of the outputs: root mean square of the difference to the fine run, over the range of that (at least a
  /// hundredth of the largest range of all of its unit); the largest of all outputs, and whose it is.
  double error = 0;
  std::string worst_output;
  double median = 0, p9999 = 0, worst = 0;  ///< CPU s of a step, as fast as they come
  int most_iterations = 0;                  ///< that a step took
  std::string failure;                      ///< why it cannot be; empty: it can
};

struct RealTimePlan {
  double deadline = 0, reference_step = 0;    ///< s
  std::shared_ptr<RealTimeMonitor> idle;      ///< the machine by itself
  std::vector<RealTimeCandidate> candidates;  ///< in the order in which they were measured
  int chosen = -1;                            ///< −1: none keeps the deadline
  std::shared_ptr<RealTimeMonitor> watched;   ///< of the chosen one, against the clock
  int watched_candidates = 0;
  double load = 0;  ///< of the chosen one: 99.99th percentile of computation and latency over its step
  /// That is more than what was asked for, though what the chosen one takes of the processor is not: the
  /// machine itself is late.
  bool machine_late = false;
};

/// Measures ways to compute the model, each over the manoeuvre as fast as it goes, and their errors against a
/// run with all modes and a sixteenth of the deadline as its step. Of those that should keep the deadline the
/// most accurate one is run against the clock; where it does not keep it, the next. What the machine itself
/// is late by counts: where it leaves time to none, the longest steps come first; but it is no reason to try
/// another one.
/// Throws InputError for a deadline or share that cannot be, std::runtime_error where the fine run fails.
RealTimePlan plan_real_time(const spec::Model& model, const RealTimePlanOptions& options);

}  // namespace mimbre
