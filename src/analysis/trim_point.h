#pragma once
#include <map>
#include <string>

#include "dynamics/relative/system.h"
#include "dynamics/state.h"
#include "mimbre/linearise.h"

/// Steady driving: straight on, or around a circle.
namespace mimbre::linear {

/// A steady motion of a mechanism on floating joints: as a whole it moves along a plane and turns about the
/// vertical with a constant rate, while some joints turn with constant speeds.
struct Trim {
  State state;                     ///< consistent accelerations
  int body = -1;                   ///< whose speed it is, of the tree
  double speed = 0, yaw_rate = 0;  ///< m/s along the plane; rad/s, to the left
  double sideslip = 0;             ///< rad, from the body's x axis to its velocity, to the left positive
  Vec3d up = Vec3d::UnitZ();       ///< against gravity, global
  std::map<std::string, double> inputs;  ///< all that are given or found
  Eigen::VectorXd accelerations;         ///< relative accelerations of that motion: of points that go round
  int iterations = 0;
  double residual = 0;  ///< largest relative acceleration that is left, of those at play
};

/// By Newton's method on the exact linear equations, from `near`, where there is one and it leads anywhere,
/// else from `start` with its velocities scaled to the speed. The joints that turn at the start go on
/// turning. Throws InputError for conditions that do not go together, std::runtime_error where it finds none.
Trim find_trim(const Compiled& model, relative::RelativeSystem& system, const State& start,
               const std::map<std::string, double>& inputs, const TrimConditions& conditions,
               const DrivingState* near = nullptr);

}  // namespace mimbre::linear
