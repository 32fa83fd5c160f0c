#pragma once
#include <vector>

#include "mimbre/channels.h"
#include "simulation/energy.h"

namespace mimbre {

/// What a run records: the model's outputs, then the standard channels (joint coordinates, spring and tyre
/// forces, energies, solver statistics), and the poses and amplitudes that a picture needs.
class Channels {
 public:
  explicit Channels(const Compiled& model);
  const std::vector<ChannelInfo>& info() const { return info_; }
  int output_count() const { return output_count_; }

  struct Statistics {
    double iterations = 0, position_violation = 0, velocity_violation = 0;
  };
  /// The system's last evaluation must be of this state (a residual with its accelerations and multipliers
  /// where needs_residual()).
  void sample(const relative::RelativeSystem& system, const State& state, const EnergyBalance& energy,
              const Statistics& statistics, ResultsRow& row) const;
  bool needs_residual() const { return needs_residual_; }

  std::vector<BodyDrawing> drawings() const;
  std::vector<RoadDrawing> roads() const;

 private:
  double output_value(const spec::Output& output, const relative::RelativeSystem& system,
                      const State& state) const;

  const Compiled& model_;
  std::vector<ChannelInfo> info_;
  int output_count_ = 0;
  int modes_ = 0;
  bool needs_residual_ = false;
  std::vector<int> joint_body_, joint_loop_;  // spec joint → tree body or loop, -1
};

}  // namespace mimbre
