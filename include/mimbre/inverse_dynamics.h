#pragma once
#include <Eigen/Core>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mimbre/channels.h"
#include "mimbre/model.h"
#include "mimbre/prescribed_motion.h"

namespace mimbre {

/// What inverse dynamics is asked.
struct InverseDynamicsOptions {
  /// Instants, s; none: those of the motion, or without one `steps` + 1 from `start` to `end`.
  std::vector<double> times;
  double start = 0;
  std::optional<double> end;  ///< default: the model's
  int steps = 200;
  double smooth = 0;  ///< s, see with_motion()
  /// Coordinates of joints along which forces are looked for; none: all that a drive or the motion
  /// prescribes.
  std::vector<JointCoordinate> forces;
  /// What flexible bodies, and joints that springs hold, do. dynamic: they follow by their own dynamics, by
  /// implicit steps of `step`. quasistatic: at each instant they are in balance with the forces and
  /// accelerations of that motion as if they were at rest in it, ẏ = ÿ = 0.
  enum class Flexible { dynamic, quasistatic } flexible = Flexible::dynamic;
  double step = 0;                       ///< s, of dynamic; 0: the model's
  std::map<std::string, double> inputs;  ///< RunOptions::inputs
};

/// Forces that make a prescribed motion.
struct InverseDynamics {
  std::vector<JointCoordinate> coordinates;  ///< along which forces are
  std::vector<std::string> names, units;     ///< of the forces: N, N m
  Eigen::VectorXd time;                      ///< s
  /// instants × coordinates: position, rate, acceleration of each, and the generalised force on it, positive
  /// where it drives the coordinate on. The model's own forces (gravity, springs, actuators with their
  /// inputs' start values) act besides.
  Eigen::MatrixXd position, velocity, acceleration, force;
  /// All channels of the results, joint reactions among them, and poses, by instant.
  ResultsHeader header;
  std::vector<ResultsRow> rows;
  int free = 0;         ///< independent motions that nothing prescribes
  int redundant = 0;    ///< forces that could be left out: those given are then the smallest, Σ force²
  double residual = 0;  ///< the most that no drive makes at an instant, by the most at play at any
  std::vector<std::string> warnings;
};

/// Generalised forces along joint coordinates that make the model move as its drives prescribe, or `motion`,
/// in place of what drives of the same coordinates prescribe; in trees and with closed loops. Without free
/// coordinates M q̈ − Q + Φqᵀ λ = 0 is solved for the forces at each instant, and their error is round-off.
/// Throws InputError for bad options and a model that cannot start, std::runtime_error with the time where
/// the motion cannot be made: loops do not close, the forces that are looked for do not suffice, a
/// quasi-static balance is not found.
InverseDynamics inverse_dynamics(const std::shared_ptr<const Model>& model,
                                 const PrescribedMotion* motion = nullptr,
                                 const InverseDynamicsOptions& options = {});

}  // namespace mimbre
