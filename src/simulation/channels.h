#pragma once
#include <vector>

#include "mimbre/channels.h"
#include "mimbre/simulation.h"
#include "simulation/energy.h"
#include "simulation/joint_channels.h"

namespace mimbre {

/// Bodies whose motion of mass an output shows: indices of compiled bodies; none for other outputs.
std::vector<int> bodies_of(const Compiled& model, const spec::Output& output);

/// What a run records: the model's outputs, then the standard channels (motion and reactions of all joints,
/// spring and tyre forces, energies, solver statistics), and the poses and amplitudes that a picture needs.
class Channels {
 public:
  explicit Channels(const Compiled& model);
  const std::vector<ChannelInfo>& info() const { return info_; }
  int output_count() const { return output_count_; }
  /// Whether a channel is what a joint bears.
  bool shows_reaction(int channel) const { return reaction_[static_cast<std::size_t>(channel)] != 0; }

  struct Statistics {
    double iterations = 0, position_violation = 0, velocity_violation = 0;
  };
  /// The system's last evaluation must be a residual of this state with its accelerations and multipliers;
  /// its scratch is used.
  void sample(relative::RelativeSystem& system, const State& state, const EnergyBalance& energy,
              const Statistics& statistics, ResultsRow& row) const;
  /// One output's value, under the same conditions; `mass_of`: bodies_of() it.
  double value(const spec::Output& output, const std::vector<int>& mass_of, relative::RelativeSystem& system,
               const State& state) const;
  /// Says in the meaning of reactions which rigid bodies do not determine.
  void mark_undetermined(const Redundancy& redundancy);

  std::vector<BodyDrawing> drawings() const;
  std::vector<RoadDrawing> roads() const;

 private:
  const Compiled& model_;
  std::vector<ChannelInfo> info_;
  std::vector<std::vector<int>> mass_of_output_;  ///< by output: compiled bodies
  int output_count_ = 0;
  int modes_ = 0;
  JointObserver joints_;
  int joint_count_ = 0;         // their channels
  std::vector<char> reaction_;  // by channel
};

}  // namespace mimbre
