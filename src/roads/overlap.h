#pragma once
#include <optional>

#include "roads/grid.h"

namespace mimbre::roads {

/// A point of a road's grid that another part of the road covers, too, where that has another height.
struct Overlap {
  double u = 0, v = 0;    ///< of the point, m
  double other_u = 0;     ///< of the part that counts there, since its line is nearer, m
  double difference = 0;  ///< of heights, m
  bool bend = false;      ///< the road bends there more tightly than it is wide
};

/// The point with the largest difference of those that differ by more than 0.1 mm. Looks at as many points,
/// evenly, as do not take long. `arrays`: of the road, without rounding.
std::optional<Overlap> worst_overlap(const RoadGrid& road, const GridArrays& arrays);

}  // namespace mimbre::roads
