#pragma once
#include <string>
#include <vector>

#include "mimbre/spec.h"

namespace mimbre {

/// A coordinate of a joint that is a number: of a revolute joint its angle.
struct JointCoordinate {
  int joint = -1;      ///< index into spec::Model::joints
  int coordinate = 0;  ///< of its velocity coordinates
  bool operator==(const JointCoordinate&) const = default;
};

/// "shoulder", or "column.1" where a joint has several coordinates (or is called so).
std::string coordinate_text(const spec::Model& model, const JointCoordinate& coordinate);
/// The coordinate of that name. Throws UnknownName, with one that is like it, where there is none.
JointCoordinate find_coordinate(const spec::Model& model, const std::string& name);

/// Coordinates of joints over time.
struct PrescribedMotion {
  struct Column {
    JointCoordinate of;
    std::vector<double> position;                ///< m or rad, by instant
    std::vector<double> velocity, acceleration;  ///< likewise; both, or none: they follow from a spline
  };
  std::vector<double> time;  ///< s, ascending
  std::vector<Column> columns;
};

/// Reads a table as mimbre/input_table.h describes it: `time`, and columns by the names of coordinates, each
/// with NAME.velocity and NAME.acceleration where these are known too (`joint.NAME.position` and so on are
/// the same). Throws InputError with file and line.
PrescribedMotion read_motion_table(const std::string& path, const spec::Model& model);

/// The model with drives that prescribe the motion, in place of those that these coordinates have. Between
/// the instants a coordinate is a spline of degree 5 (not-a-knot); where velocities and accelerations are
/// given, the polynomials of degree 5 with these. `smooth`, s: of motions shorter than this less than half is
/// left (the smoothing spline of degree 5; natural ends); 0: none is smoothed. Throws InputError for what is
/// no such motion.
spec::Model with_motion(spec::Model model, const PrescribedMotion& motion, double smooth = 0);

}  // namespace mimbre
