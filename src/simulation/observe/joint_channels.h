#pragma once
#include <vector>

#include "dynamics/relative/system.h"
#include "dynamics/state.h"
#include "mimbre/channels.h"
#include "outputs/view.h"

/// What every joint of a mechanism does, whether it is in the tree or cut: its coordinates, their rates, and
/// what it transmits.
namespace mimbre {

class JointObserver {
 public:
  explicit JointObserver(const Compiled& model);

  /// Of spec joint `joint`; the system's last evaluation must be of this state.
  JointCoordinates coordinates(int joint, const relative::RelativeSystem& system, const State& state) const;
  /// Likewise, after a residual with the state's accelerations and multipliers.
  JointReaction reaction(int joint, const relative::RelativeSystem& system, const State& state) const;

  /// The standard channels of a joint: of its motion, and of what it transmits.
  void add_motion_info(int joint, std::vector<ChannelInfo>& channels) const;
  void add_reaction_info(int joint, std::vector<ChannelInfo>& channels) const;
  /// Their values, in the same order.
  void read_motion(int joint, const relative::RelativeSystem& system, const State& state,
                   double* values) const;
  void read_reaction(int joint, const relative::RelativeSystem& system, const State& state,
                     double* values) const;

 private:
  const Compiled& model_;
  std::vector<int> body_, loop_;  // spec joint → tree body or loop, -1
};

}  // namespace mimbre
