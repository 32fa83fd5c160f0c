#pragma once
#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "mimbre/channels.h"
#include "mimbre/method.h"
#include "mimbre/model.h"

namespace mimbre {

/// Static equilibrium of a model with the inputs of the options: outputs by name and value. Throws
/// std::runtime_error when it is not found, InputError where loops do not close or there is no such input.
struct StaticResult {
  std::vector<ChannelInfo> channels;  ///< the model's outputs first
  Eigen::VectorXd values;             ///< of the channels
  int output_count = 0;
  int iterations = 0;
  double cpu_seconds = 0;
  double residual = 0;  ///< the generalised force that is left and does most work, N or N m
  bool stable = true;   ///< no small disturbance grows
  bool sparse = false;  ///< by sparse matrices: of large mechanisms, and where the dense search found nothing
  /// Equilibria on the way, at each of which more of the forces that are not balanced at the start was
  /// applied; 0: all were applied at once.
  int load_steps = 0;
  std::vector<std::string> warnings;
};
StaticResult static_equilibrium(std::shared_ptr<const Model> model, const RunOptions& options = {});

}  // namespace mimbre
