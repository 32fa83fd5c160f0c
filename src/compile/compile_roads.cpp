#include "compile/compile_parts.h"
#include "compile/signals/compile_signals.h"

namespace mimbre {
namespace {

RoadData road_data(const spec::Road& r) {
  RoadData road;
  road.over = r.over;
  road.height = r.height.data();
  road.friction = r.friction;
  for (const spec::Road::Patch& p : r.patches)
    road.patches.push_back({{p.low[0], p.low[1]}, {p.high[0], p.high[1]}, p.friction});
  road.origin = {r.origin[0], r.origin[1]};
  road.spacing = {r.spacing[0], r.spacing[1]};
  road.rows = static_cast<int>(r.heights.rows());
  road.columns = static_cast<int>(r.heights.cols());
  for (int j = 0; j < road.rows; ++j)
    for (int i = 0; i < road.columns; ++i) road.heights.push_back(r.heights(j, i));
  if (r.along_line.along() > 0) road.own = roads::arrays_of(r.along_line, roads::file_rounding);
  return road;
}

}  // namespace

void compile_roads(Compiled& c) {
  for (const spec::Road& r : c.spec().roads) c.roads.push_back(road_data(r));
  place_roads(c);
}

}  // namespace mimbre
