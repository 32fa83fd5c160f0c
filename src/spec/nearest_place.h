#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <vector>

/// Which places are the same, and which of a flexible body's nodes is meant by a place that was given.
namespace mimbre {

/// Whether two places differ by no more than the round-off of their coordinates.
inline bool at_one_place(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  constexpr double round_off = 1e3 * std::numeric_limits<double>::epsilon();
  return !((a - b).norm() > round_off * (a.norm() + b.norm()));
}

/// How far apart places are the same, m, on a body with these nodes: a share of its size, and the round-off
/// of coordinates that far from the origin, which they are the differences of.
inline double place_tolerance(const std::vector<Eigen::Vector3d>& nodes, double far) {
  constexpr double share = 1e-6, round_off = 1e3 * std::numeric_limits<double>::epsilon();
  double extent = 0;
  for (const Eigen::Vector3d& node : nodes) extent = std::max(extent, node.norm());
  return std::max(share * extent, round_off * far);
}

/// The nearest node, counted from 0, where it is within that distance; else −1. Of several the first.
inline int nearest_place(const std::vector<Eigen::Vector3d>& nodes, const Eigen::Vector3d& place,
                         double within) {
  int nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < nodes.size(); ++k)
    if (const double distance = (nodes[k] - place).norm(); distance < least) {
      least = distance;
      nearest = static_cast<int>(k);
    }
  return least <= within ? nearest : -1;
}

}  // namespace mimbre
