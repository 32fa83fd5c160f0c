#pragma once
#include <vector>

#include "mimbre/channels.h"
#include "mimbre/simulation.h"
#include "simulation/observe/channel_view.h"
#include "simulation/observe/joint_channels.h"
#include "simulation/observe/run_channels.h"
#include "simulation/step/energy.h"

namespace mimbre {

/// What a run records: the model's outputs, then the standard channels (motion and reactions of all joints,
/// spring and tyre forces, energies, solver statistics), and the poses and amplitudes that a picture needs.
class Channels {
 public:
  explicit Channels(const Compiled& model);
  const std::vector<ChannelInfo>& info() const { return info_; }
  int output_count() const { return output_count_; }

  /// What of a state must be evaluated for a channel; each includes those before.
  using Needs = OutputInfo::Needs;
  /// Channels next to each other that are read together.
  struct Part {
    enum class Kind {
      output,
      joint,
      reaction,
      spring,
      tyre,
      road,
      wheel,
      load,
      element,
      constraint,
      contact,
      input,
      signal,
      event,
      energy,
      solver
    };
    Kind kind;
    int item;  ///< the output, joint, element, slot
    int first, count;
    Needs needs;
  };
  const std::vector<Part>& parts() const { return parts_; }
  /// The number of a channel's part.
  int part_of(int channel) const { return part_of_[static_cast<std::size_t>(channel)]; }

  using Statistics = RunStatistics;
  /// Puts a part's channels to their places among all. The system's last evaluation must be what the part
  /// needs: kinematics, or a residual, of this state with its accelerations and multipliers. Its scratch is
  /// used.
  void read(const Part& part, relative::RelativeSystem& system, const State& state,
            const EnergyBalance& energy, const Statistics& statistics, double* channels) const;
  /// All of them, with poses and amplitudes, after a residual.
  void sample(relative::RelativeSystem& system, const State& state, const EnergyBalance& energy,
              const Statistics& statistics, ResultsRow& row) const;
  /// Time, poses and amplitudes alone, after kinematics.
  void picture(const relative::RelativeSystem& system, const State& state, ResultsRow& row) const;
  /// One output's value, likewise.
  double value(const ObservedOutput& output, relative::RelativeSystem& system, const State& state) const;
  /// Notes in the meaning of reactions which rigid bodies do not determine.
  void mark_undetermined(const Redundancy& redundancy);

  std::vector<RoadDrawing> roads() const;

 private:
  void add_outputs();
  void add_joints();
  void add_elements();
  void add_signals();
  /// Makes what has been described since the last call the channels of a part.
  void close_part(Part::Kind kind, int item, Needs needs);

  const Compiled& model_;
  std::vector<ChannelInfo> info_;
  std::vector<Part> parts_;
  std::vector<int> part_of_;
  std::vector<ObservedOutput> outputs_;
  int output_count_ = 0;
  const bool draws_ground_;  ///< behind the bodies
  int modes_ = 0;
  JointObserver joints_;
};

}  // namespace mimbre
