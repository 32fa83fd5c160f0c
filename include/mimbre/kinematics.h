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

struct KinematicsOptions {
  double start = 0;           ///< s
  std::optional<double> end;  ///< s; default: the model's
  int steps = 200;
  std::map<std::string, double> inputs;  ///< RunOptions::inputs
};

/// A position in which the mechanism is singular, or a coordinate turns back.
struct SpecialPosition {
  enum class Kind {
    dead_centre,   ///< the drives do not determine the motion: `joint` could move while they stand still
    change_point,  ///< the loops alone leave a motion more: the mechanism can go on in another way
    limit,         ///< the drive of `joint` cannot go further: the loops do not close beyond
    reversal       ///< the coordinate of `joint` turns back: a dead centre if it were driven there
  } kind = Kind::dead_centre;
  double time = 0;      ///< s
  JointCoordinate of;   ///< which
  double position = 0;  ///< its coordinate there, m or rad
  double driven = 0;    ///< coordinate of the first drive there
  std::string joint;    ///< name of that coordinate
  std::string text;     ///< the same in words
};

/// Motion by drives alone, without forces and masses.
struct Kinematics {
  Eigen::VectorXd time;                              ///< s, as far as the motion goes
  std::vector<std::string> names;                    ///< of all scalar joint coordinates in the tree
  Eigen::MatrixXd position, velocity, acceleration;  ///< instants × coordinates
  /// Least singular value of the Jacobian of all equations, by the scales of the mechanism, by instant: 0 in
  /// a singular position.
  Eigen::VectorXd regularity;
  ResultsHeader header;  ///< channels of positions and velocities
  std::vector<ResultsRow> rows;
  int coordinates = 0, equations = 0;  ///< of joints; of loops and constraints, without drives
  int mobility = 0;                    ///< independent motions that loops and constraints leave
  int drives = 0;
  int free = 0;                              ///< independent motions that the drives do not prescribe
  std::vector<std::string> free_joints;      ///< that take part in these
  int redundant = 0;                         ///< equations that repeat others
  std::vector<std::string> redundant_names;  ///< joints and constraints concerned
  std::vector<SpecialPosition> special;      ///< in the order of time
  std::vector<std::string> warnings;
  bool complete = true;  ///< the motion goes to its end
};

/// Positions, velocities and accelerations that the drives prescribe, followed from the assembled position.
/// What no drive prescribes moves as little as possible. Flexible bodies stay as they are unless loops need
/// them. Singular positions on the way are looked for between the instants (the minima of the least singular
/// value, to 1e-8 of the interval), and coordinates that turn back. Throws InputError for a model that cannot
/// be assembled and for bad options.
Kinematics kinematics(const std::shared_ptr<const Model>& model, const KinematicsOptions& options = {});

}  // namespace mimbre
