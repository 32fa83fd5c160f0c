#pragma once
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mimbre/channels.h"
#include "mimbre/linearise.h"

namespace mimbre {

/// The condition of that name: speed, lateral_acceleration, yaw_rate or radius; null: there is none.
std::optional<double>* held_condition(TrimConditions& conditions, std::string_view name);

/// Steady driving of a model: what its inputs must be, and its outputs (docs/linear-analyses.md).
struct TrimResult {
  std::string body;  ///< whose motion it is
  double speed = 0;  ///< m/s, of its origin along the plane across gravity
  double yaw_rate = 0,
         lateral_acceleration = 0;  ///< rad/s, m/s² (yaw rate times speed); to the left positive
  double sideslip = 0;              ///< rad, from the body's x axis to its velocity, to the left positive
  struct Input {
    std::string name, unit;
    double value = 0;
  };
  std::vector<Input> found;           ///< as in TrimConditions::find
  std::vector<ChannelInfo> channels;  ///< the model's outputs first
  Eigen::VectorXd values;             ///< of the channels
  int output_count = 0;
  int iterations = 0;
  double residual = 0;  ///< largest relative acceleration that is left, of those at play
  double cpu_seconds = 0;
};

/// Finds it from the start of the model, whose turning joints go on turning. Throws InputError where
/// conditions do not go together or a name is wrong, std::runtime_error where there is no such motion.
TrimResult trim(std::shared_ptr<const Model> model, const TrimConditions& conditions,
                const RunOptions& options = {});

}  // namespace mimbre
