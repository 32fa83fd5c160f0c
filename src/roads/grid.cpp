#include "roads/grid.h"

#include "math/elementary.h"

namespace mimbre::roads {

GridArrays arrays_of(const RoadGrid& road) {
  GridArrays out;
  const std::size_t n = road.along();
  for (std::size_t i = 0; i < n; ++i) {
    // Directions of the segments to and from the point; the line's ends have one.
    const std::size_t before = i > 0 ? i - 1 : 0, after = i > 0 ? i : 1, here = i + 1 < n ? i : n - 2,
                      next = here + 1;
    const double ax = road.x[after] - road.x[before], ay = road.y[after] - road.y[before];
    const double bx = road.x[next] - road.x[here], by = road.y[next] - road.y[here];
    const double a = mimbre::hypot(ax, ay), b = mimbre::hypot(bx, by);
    const double tx = ax / a + bx / b, ty = ay / a + by / b;
    // The normal of both together, of length 1 across each.
    const double across = (tx * ax + ty * ay) / a;
    for (const double number :
         {road.x[i], road.y[i], -ty / across, tx / across, road.line_height[i], road.bank[i]})
      out.line.push_back(number);
  }
  const std::size_t in_block =
      std::max<std::size_t>(8, static_cast<std::size_t>(std::sqrt(static_cast<double>(n))));
  out.in_block = static_cast<int>(in_block);
  for (std::size_t first = 0; first + 1 < n; first += in_block) {
    const std::size_t last = std::min(first + in_block, n - 1);
    const double x = (road.x[first] + road.x[last]) / 2, y = (road.y[first] + road.y[last]) / 2;
    double radius = 0;
    for (std::size_t i = first; i <= last; ++i)
      radius = std::max(radius, mimbre::hypot(road.x[i] - x, road.y[i] - y));
    for (const double number : {x, y, radius}) out.blocks.push_back(number);
  }
  out.v = road.v;
  out.height = road.height;
  return out;
}

GridData view_of(const GridArrays& arrays) {
  return {arrays.line.data(),
          arrays.blocks.data(),
          arrays.v.data(),
          arrays.height.data(),
          static_cast<int>(arrays.line.size() / grid::line_numbers),
          static_cast<int>(arrays.v.size()),
          arrays.in_block};
}

}  // namespace mimbre::roads
