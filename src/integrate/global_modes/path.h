#pragma once
#include <vector>

#include "integrate/global_modes/loops.h"
#include "integrate/global_modes/probe.h"

/// The ways of a loop of rigid bodies.
namespace mimbre::global_modes {

/// A place on the way of a loop that can move in one way.
struct Place {
  Eigen::VectorXd q;  ///< positions of the whole system: the loop's closed, without deflections
  /// How the loop's rigid coordinates (Loop::rigid) go on from here, along their scales; the largest is 1.
  Eigen::VectorXd tangent;
};

struct Path {
  std::vector<Place> places;  ///< equally far from each other
  std::size_t start = 0;      ///< the one where the system is
};

/// Follows the loop from where the system is in both directions, to where it could go on in several ways, or
/// until a coordinate has made more than a turn. Throws NoGlobalModes where it can move in no way, or in
/// several.
Path follow_loop(Probe& probe, const Loop& loop, const CoordinateKinds& kinds, const Eigen::VectorXd& q);

/// The coordinate that describes the longest part of the path, and that part: places from `first` to `last`.
struct Parameter {
  int coordinate = -1;  ///< velocity coordinate
  std::size_t first = 0, last = 0;
};
Parameter choose_parameter(const Path& path, const Loop& loop, const CoordinateKinds& kinds);

/// The closed loop at a value of the parameter, from a place nearby.
Eigen::VectorXd place_at(Probe& probe, const Loop& loop, const CoordinateKinds& kinds, const Place& near,
                         int coordinate, double value);

}  // namespace mimbre::global_modes
