#include "roads/overlap.h"

#include <algorithm>
#include <cmath>

namespace mimbre::roads {
namespace {

/// Whether lines of constant u cross within one of these segments, on that side.
bool folds(const GridArrays& g, int first, int last, double v) {
  for (int i = std::max(first, 0); i <= std::min(last, grid::points(g) - 2); ++i) {
    const double* a = grid::point(g, i);
    const double* b = grid::point(g, i + 1);
    const double dx = b[0] - a[0], dy = b[1] - a[1];
    if (dx * dx + dy * dy + v * ((b[2] - a[2]) * dx + (b[3] - a[3]) * dy) <= 0) return true;
  }
  return false;
}

}  // namespace

std::optional<Overlap> worst_overlap(const RoadGrid& road, const GridArrays& g) {
  constexpr std::size_t most_points = 200000;
  constexpr double same = 1e-4;  // m
  const std::size_t across = road.across(), each = 1 + road.height.size() / most_points;
  std::optional<Overlap> worst;
  int first = 0, last = 0;  // segments between the two parts
  for (std::size_t i = 0; i < road.along(); i += each)
    for (std::size_t k = 0; k < across; ++k) {
      const double v = road.v[k];
      if (v < g.right[i] || v > g.left[i]) continue;
      const double* p = grid::point(g, static_cast<int>(i));
      const double x = p[0] + v * p[2], y = p[1] + v * p[3];
      const double difference = std::abs(grid_height(g, x, y).z - g.height[i * across + k]);
      if (!(difference > (worst ? worst->difference : same))) continue;
      const grid::OnSegment at = grid::spot(g, x, y);
      const int here = static_cast<int>(i);
      worst = {road.start_u + road.increment * static_cast<double>(i), v,
               road.start_u + road.increment * (at.segment + at.f), difference, false};
      first = std::min(here - 1, at.segment);
      last = std::max(here, at.segment);
    }
  if (worst) worst->bend = folds(g, first, last, worst->v);
  return worst;
}

}  // namespace mimbre::roads
