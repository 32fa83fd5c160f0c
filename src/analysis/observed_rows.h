#pragma once
#include "dynamics/relative/system.h"
#include "dynamics/state.h"
#include "simulation/observe/channels.h"

namespace mimbre {

/// Channels of states that no run has made: all but energies, events and the solver's.
class ObservedRows {
 public:
  /// `reactions`: forces and multipliers are known too, else positions, velocities and accelerations.
  ObservedRows(const Compiled& model, bool reactions);
  ResultsHeader header(const std::string& options_json) const;
  /// After the system's residual at the state, or its kinematics.
  ResultsRow row(relative::RelativeSystem& system, const State& state) const;
  Channels& channels() { return channels_; }

 private:
  const Compiled& model_;
  Channels channels_;
  std::vector<Channels::Part> parts_;
};

}  // namespace mimbre
