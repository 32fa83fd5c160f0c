#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "dynamics/relative/system.h"
#include "mimbre/channels.h"

namespace mimbre {

struct AtRest {
  std::vector<ChannelInfo> channels;  ///< the model's outputs first
  Eigen::VectorXd values;             ///< of the channels
  int output_count = 0;
  std::vector<std::string> warnings;  ///< of equations that repeat others
};

/// All channels of a mechanism that rests in equilibrium, of which the state has the multipliers.
AtRest sample_at_rest(const Compiled& model, relative::RelativeSystem& system, State& state);

}  // namespace mimbre
