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
  double step = 0;    ///< s; 0: not known
  double length = 0;  ///< typical of the mechanism, m; 0: not known
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
  double scale = 0;                ///< what differences are measured by
  double relative_difference = 0;  ///< of the scale
};

/// The largest difference of every channel that both have, but for what the
/// integration makes of its own (solver.*, energy.numerical), in the order of `a`, over the instants that
/// both have (the first ones: a run may have ended early).
///
/// What differs is measured by the channel's own scale: its range; where its zero means something
/// (velocities, forces, energies; not positions, angles and the potential energy) at least a tenth of its
/// largest value, so that what is constant is not measured by its own error. What hardly moves beside others
/// of its unit (a vehicle on a straight road, sideways; a joint without load) has round-off for a
/// range: its scale is at least 1e-4 of the largest range of its unit, 1e-3 of the largest value where zero
/// means something (what the iterations' tolerance leaves of forces and energies is a share of those at
/// play), and 1e-6 of its own largest value. Where everything is at rest, lengths, angles, velocities and
/// accelerations count from a thousandth of what gravity does in a step, and lengths (of the mechanism's) and
/// angles from 1e-7, to a hundredth of which loops are closed at the start; quaternions are angles. Reactions
/// that redundant constraints leave open are not compared.
std::vector<Apart> differences(const Series& a, const Series& b);

/// A channel at the step and, where they were made, at half and a quarter of it.
struct Refined {
  Apart whole;  ///< between the formulations
  std::optional<Apart> half, quarter;
  /// What halving the step changes in each formulation (from the step to its half), and halving it again.
  /// Both formulations may be wrong alike, but not at two steps.
  std::array<std::optional<Apart>, 2> step, half_step;
  /// How many times smaller the largest difference is with half the step (of the two shortest): 4 where both
  /// runs are of second order. Nothing where it is so small (a billionth of the scale) that only round-off
  /// and the iterations' tolerance are left, or not a number.
  std::optional<double> ratio() const;
  const Apart& finest() const { return quarter ? *quarter : half ? *half : whole; }
  /// What half the step changes in the worse formulation, the root mean square of the scale; 0 where it is
  /// not known.
  double step_error() const;
  /// Between the formulations: the finest difference is at most 1 % of the scale, or it falls with the step,
  /// by 2 at least: the largest, or the mean square's root (the peak of an impact comes a step earlier or
  /// later, however short the steps are).
  bool together() const;
  /// In each formulation, as the root mean square (again for the peaks): half the step changes at most 1 % of
  /// the scale; or at most 25 %, and what half of it changes again is less, by 1.5 at least (impacts are of
  /// first order), and, where it is more than 5 %, by 16 at most (else the longer step did what no shorter
  /// one does).
  bool settled() const;
  bool agrees() const { return together() && settled(); }
  /// Runs with a quarter of the step may still make it agree.
  bool undecided() const;
};

/// Results over all channels.
struct Agreement {
  std::vector<Refined> channels;  ///< those that disagree first, the worst (at the finest step) of them first
  bool agree = true;
  bool undecided() const;  ///< no channel is lost, and one is undecided
  /// How many times smaller the difference, as the root mean square of all instants and channels over their
  /// scales, is with half the step; nothing as in Refined::ratio().
  std::optional<double> ratio;
};

/// What there is to judge by: the formulations against each other at the step, its half and its quarter, and
/// each against itself from the step to its half, and from there to its quarter. All but the first may be
/// empty (not made); otherwise they have the same channels.
struct Comparison {
  std::vector<Apart> whole, half, quarter;
  std::array<std::vector<Apart>, 2> step, half_step;
};

/// What is not a number is the worst.
Agreement agreement(const Comparison& comparison);
/// Of the formulations against each other only; `half` may be empty.
Agreement agreement(const std::vector<Apart>& whole, const std::vector<Apart>& half);

/// The verdict in words, a sentence a line.
std::string verdict(const Agreement& agreement);

/// A run in one formulation.
struct VerificationRun {
  double step = 0;  ///< s
  int coordinates = 0, constraints = 0;
  RunTotals totals;
  double energy_drift = 0;  ///< J, that the numerics put in; NaN when the run did not come so far
  std::vector<std::string> warnings;
  std::string failure;  ///< empty: it came to its end
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
  std::optional<VerificationPair> half;     ///< with half the step
  std::optional<VerificationPair> quarter;  ///< with a quarter of it, where that had to be known
  /// Steps that one run repeated in parts and the other did not made them differ, so that all runs were made
  /// again without repeats; these are what is compared.
  bool without_repeats = false;
  std::int64_t repeated_steps = 0;  ///< in all runs, as they were before that
  Agreement agreement;
  double energy_at_play = 0;  ///< J, the largest scale of a term of the balance in the first runs
  bool interrupted = false;   ///< `stop` ended it; the rest is of no use

  /// "the natural formulation failed with the step 0.01 s: …", a line for each failure.
  std::vector<std::string> failures() const;
  /// What the runs warned of, each once: "in natural coordinates: …".
  std::vector<std::string> warnings() const;
  bool compared() const { return whole.ok(); }
  bool ran() const { return compared() && whole.runs[0].totals.steps > 0; }
  /// The numerics put in or took out more than a tenth of the energy at play, and hardly less with half the
  /// step, so that no shorter step shows it: a stiff spring's vibration that every step damps at once.
  bool energy_lost() const;
  /// Where nothing ran, nothing agrees.
  bool agree() const {
    return ran() && !agreement.channels.empty() && (!half || half->ok()) && (!quarter || quarter->ok()) &&
           agreement.agree && !energy_lost();
  }
};

/// The verdict in words, a sentence a line.
std::string verdict(const Verification& verification);

struct VerifyOptions {
  RunOptions run;      ///< but for the formulation
  double end = -1;     ///< s; negative: the model's
  bool refine = true;  ///< also with half the step, and with a quarter of it where that decides
  /// Called now and then with the time reached, the end (s) and CPU seconds.
  std::function<void(double time, double end, double cpu_seconds)> progress;
  std::function<bool()> stop;  ///< asked before each step
};

/// Runs a model in both formulations and compares all channels. Failures of a run are reported in it, not
/// thrown, but for a model that cannot start in relative coordinates (InputError).
Verification verify(std::shared_ptr<const Model> model, const VerifyOptions& options = {});

}  // namespace mimbre
