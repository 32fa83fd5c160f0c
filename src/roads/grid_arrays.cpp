#include "roads/grid.h"

namespace mimbre::roads {
namespace {

double distance(const RoadGrid& road, std::size_t a, std::size_t b) {
  const double dx = road.x[b] - road.x[a], dy = road.y[b] - road.y[a];
  return std::sqrt(dx * dx + dy * dy);
}

/// Bank and slope of the line included, which are linear between the grid's points, too.
Array<double> heights_of(const RoadGrid& road) {
  Array<double> heights;
  heights.reserve(road.height.size());
  for (std::size_t i = 0; i < road.along(); ++i)
    for (std::size_t k = 0; k < road.across(); ++k)
      heights.push_back(road.height[i * road.across() + k] + road.line_height[i] + road.bank[i] * road.v[k]);
  return heights;
}

/// Whether the line ends at its start, in about the direction in which it begins, at the same heights.
bool is_closed(const RoadGrid& road, const Array<double>& heights) {
  constexpr double same_place = 1e-3, same_height = 1e-4;  // of a segment; m
  const std::size_t n = road.along(), across = road.across();
  if (n < 4 || distance(road, n - 1, 0) > same_place * distance(road, 0, 1)) return false;
  const double forth = (road.x[1] - road.x[0]) * (road.x[n - 1] - road.x[n - 2]) +
                       (road.y[1] - road.y[0]) * (road.y[n - 1] - road.y[n - 2]);
  if (!(forth > 0)) return false;
  for (std::size_t k = 0; k < across; ++k)
    if (!(std::abs(heights[(n - 1) * across + k] - heights[k]) <= same_height)) return false;
  return true;
}

Array<double> line_of(const RoadGrid& road, bool closed) {
  Array<double> line;
  const std::size_t n = road.along();
  for (std::size_t i = 0; i < n; ++i) {
    // The segments to and from the point; of the ends of a line that is not closed there is one.
    const std::size_t to = i > 0 ? i : closed ? n - 1 : 1, from = i + 1 < n ? i : closed ? 0 : n - 2;
    const double ax = road.x[to] - road.x[to - 1], ay = road.y[to] - road.y[to - 1];
    const double bx = road.x[from + 1] - road.x[from], by = road.y[from + 1] - road.y[from];
    const double a = std::sqrt(ax * ax + ay * ay), b = std::sqrt(bx * bx + by * by);
    const double tx = ax / a + bx / b, ty = ay / a + by / b;
    // The normal of both together, of length 1 across each.
    const double across = (tx * ax + ty * ay) / a;
    for (const double number : {road.x[i], road.y[i], -ty / across, tx / across}) line.push_back(number);
  }
  return line;
}

SegmentCircle circle_around(const RoadGrid& road, int first, int count) {
  const auto begin = static_cast<std::size_t>(first), end = static_cast<std::size_t>(first + count);
  SegmentCircle c{(road.x[begin] + road.x[end]) / 2, (road.y[begin] + road.y[end]) / 2, 0, first, count};
  for (std::size_t i = begin; i <= end; ++i) {
    const double dx = road.x[i] - c.x, dy = road.y[i] - c.y;
    c.radius = std::max(c.radius, std::sqrt(dx * dx + dy * dy));
  }
  // So that no round-off hides a segment behind its own circle.
  c.radius *= 1 + 1e-12;
  return c;
}

/// Halves of halves, down to a few segments.
Array<SegmentCircle> circles_around(const RoadGrid& road) {
  constexpr int few = 4;
  Array<SegmentCircle> circles;
  circles.push_back(circle_around(road, 0, static_cast<int>(road.along()) - 1));
  for (std::size_t k = 0; k < circles.size(); ++k) {
    const int first = circles[k].first, count = circles[k].count;
    if (count <= few) continue;
    circles[k].first = static_cast<int>(circles.size());
    circles[k].count = 0;
    circles.push_back(circle_around(road, first, count / 2));
    circles.push_back(circle_around(road, first + count / 2, count - count / 2));
  }
  return circles;
}

/// Of a width w the height at a kink changes by w/8 of the change of slope there. `most`: no wider, so that
/// neighbours' roundings do not meet.
double width_for(double kink, double most, double rounding) {
  return 8 * rounding < most * kink ? 8 * rounding / kink : rounding > 0 ? most : 0;
}

void round_kinks(GridArrays& g, double rounding) {
  const std::size_t n = g.line.size() / grid::line_numbers, across = g.v.size();
  const auto at = [&](std::size_t i, std::size_t k) { return g.height[i * across + k]; };
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t before = i > 0      ? i - 1
                               : g.closed ? n - 2
                                          : 0,
                      behind = i + 1 < n  ? i + 1
                               : g.closed ? 1
                                          : n - 1;
    double kink = 0;
    for (std::size_t k = 0; k < across; ++k)
      kink = std::max(kink, std::abs(at(before, k) - 2 * at(i, k) + at(behind, k)));
    g.rounding_along.push_back(width_for(kink, 1, rounding));
  }
  for (std::size_t k = 0; k < across; ++k) {
    const double right = k > 0 ? g.v[k] - g.v[k - 1] : INFINITY,
                 left = k + 1 < across ? g.v[k + 1] - g.v[k] : INFINITY;
    double kink = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double here = k > 0 ? (at(i, k) - at(i, k - 1)) / right : 0,
                   next = k + 1 < across ? (at(i, k + 1) - at(i, k)) / left : 0;
      kink = std::max(kink, std::abs(next - here));
    }
    g.rounding_across.push_back(width_for(kink, std::min(right, left), rounding));
  }
}

}  // namespace

GridArrays arrays_of(const RoadGrid& road, double rounding) {
  GridArrays g;
  g.height = heights_of(road);
  g.closed = is_closed(road, g.height) ? 1 : 0;
  g.line = line_of(road, g.closed != 0);
  g.circles = circles_around(road);
  g.v = road.v;
  g.right = road.right.empty() ? Array<double>(road.along(), road.v.front()) : Array<double>(road.right);
  g.left = road.left.empty() ? Array<double>(road.along(), road.v.back()) : Array<double>(road.left);
  round_kinks(g, rounding);
  return g;
}

}  // namespace mimbre::roads
