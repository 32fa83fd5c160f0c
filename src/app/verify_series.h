#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "mimbre/results.h"

/// Comparison of two runs of one model whose difference should vanish with the step.
namespace mimbre::app {

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

}  // namespace mimbre::app
