#pragma once
#include <array>
#include <string>
#include <vector>

#include "dynamics/relative/system.h"
#include "dynamics/state.h"
#include "mimbre/channels.h"

/// What every joint of a mechanism does, whether it is in the tree or cut: its coordinates, their rates, and
/// what it transmits.
namespace mimbre {

/// Coordinates of a joint as joint_motion() takes them (quaternions w, x, y, z; those of a cut joint follow
/// from its frames, angles within ±π), their rates, and the rates of these.
struct JointCoordinates {
  std::array<double, 7> positions{};
  std::array<double, 6> rates{}, accelerations{};
};

/// Force and moment about the joint's point that a joint exerts on its second body, what springs and drives
/// in it do included.
struct JointReaction {
  Vec3d force, moment;              ///< global axes
  Vec3d force_joint, moment_joint;  ///< axes of the joint's frame on its second body
};

class JointObserver {
 public:
  explicit JointObserver(const Compiled& model);

  /// Of spec joint `joint`; the system's last evaluation must be of this state.
  JointCoordinates coordinates(int joint, const relative::RelativeSystem& system, const State& state) const;
  /// Likewise, after a residual with the state's accelerations and multipliers.
  JointReaction reaction(int joint, const relative::RelativeSystem& system, const State& state) const;

  /// Which other values mean the same as a coordinate's.
  ChannelInfo::Alike alike(int joint, int position) const;

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
