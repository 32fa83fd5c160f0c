#pragma once
#include <Eigen/Core>
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "mimbre/run.h"

/// One model in both formulations, and how far they lie apart: two runs whose difference should vanish with
/// the step.
namespace mimbre {

/// Channels of a run at its output instants.
struct Series {
  std::vector<ChannelInfo> info;
  std::vector<double> time;               ///< s
  std::vector<Eigen::VectorXd> channels;  ///< one per instant
};

/// How far two runs lie apart in a channel.
struct Apart {
  std::string name, unit;
  double max_difference = 0;       ///< not a number where one of the runs is not
  double rms_difference = 0;       ///< root mean square over the instants
  double time = 0;                 ///< of the largest, s
  double range = 0;                ///< what the channel sweeps in both runs
  double scale = 0;                ///< its range, or more where that is next to nothing
  double relative_difference = 0;  ///< of the scale
};

/// The largest difference of every channel that both have, but for what the
/// integration makes of its own (solver.*, energy.numerical), in the order of `a`, over the instants that
/// both have (the first ones: a run may have ended early).
///
/// What differs is measured by the channel's range. A channel that hardly moves beside others of its unit (a
/// vehicle on a straight road, sideways) has round-off for a range: its scale is then 1e-4 of the largest
/// range of its unit, or 1e-6 of its own largest value.
std::vector<Apart> differences(const Series& a, const Series& b);

/// A channel at the step and, if that was made, at half of it.
struct Refined {
  Apart whole;
  std::optional<Apart> half;
  /// How many times smaller the largest difference is with half the step: 4 where both runs are of second
  /// order. Nothing where it is so small (a billionth of the scale) that only round-off and the iterations'
  /// tolerance are left, or not a number.
  std::optional<double> ratio() const;
  const Apart& finest() const { return half ? *half : whole; }
  /// The finest difference is at most 1 % of the scale, or it falls with the step, by 2 at least: the
  /// largest, or the mean square's root (the peak of an impact comes a step earlier or later, however short
  /// the steps are).
  bool agrees() const;
};

/// What is said of all channels.
struct Agreement {
  std::vector<Refined> channels;  ///< the worst (at the finest step) first
  bool agree = true;
  /// How many times smaller the difference, as the root mean square of all instants and channels over their
  /// scales, is with half the step; nothing as in Refined::ratio().
  std::optional<double> ratio;
};

/// `half` may be empty (not made); otherwise it has the same channels. What is not a number is the worst.
Agreement agreement(const std::vector<Apart>& whole, const std::vector<Apart>& half);

/// The verdict in words, a sentence a line.
std::string verdict(const Agreement& agreement);

/// A run in one formulation.
struct VerificationRun {
  double step = 0;  ///< s
  int coordinates = 0, constraints = 0;
  RunTotals totals;
  double energy_drift = 0;  ///< J, that the numerics put in; NaN when the run did not come so far
  std::string failure;      ///< empty: it came to its end
  bool ok() const { return failure.empty(); }
};

/// In relative and in natural coordinates, at one step.
struct VerificationPair {
  std::array<VerificationRun, 2> runs;
  bool ok() const { return runs[0].ok() && runs[1].ok(); }
};

struct Verification {
  Method method;  ///< of both, but for the formulation
  double end = 0;
  VerificationPair whole;
  std::optional<VerificationPair> half;  ///< with half the step
  Agreement agreement;
  bool interrupted = false;  ///< `stop` ended it; the rest is of no use

  /// "the natural formulation failed with the step 0.01 s: …", a line for each failure.
  std::vector<std::string> failures() const;
  bool compared() const { return whole.ok(); }
  bool agree() const { return compared() && (!half || half->ok()) && agreement.agree; }
};

struct VerifyOptions {
  RunOptions run;      ///< but for the formulation
  double end = -1;     ///< s; negative: the model's
  bool refine = true;  ///< also with half the step
  /// Called now and then with the time reached, the end (s) and CPU seconds.
  std::function<void(double time, double end, double cpu_seconds)> progress;
  std::function<bool()> stop;  ///< asked before each step
};

/// Runs a model in both formulations and compares all channels. What goes wrong in a run is told by it, not
/// thrown, but for a model that cannot start in relative coordinates (InputError).
Verification verify(std::shared_ptr<const Model> model, const VerifyOptions& options = {});

}  // namespace mimbre
