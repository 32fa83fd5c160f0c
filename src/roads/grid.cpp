#include "roads/grid.h"

#include <array>
#include <limits>

namespace mimbre::roads {
namespace grid {

int nearest_segment(const GridArrays& g, double x, double y) {
  const auto distance_to = [&](const SegmentCircle& c) {
    const double dx = x - c.x, dy = y - c.y;
    return std::max(0.0, std::sqrt(dx * dx + dy * dy) - c.radius);
  };
  struct Waiting {
    int circle;
    double distance;
  };
  // One waits on each level of the tree, which halves what is below.
  std::array<Waiting, 64> waiting;
  std::size_t count = 0;
  waiting[count++] = {0, 0};
  int found = 0;
  double nearest = std::numeric_limits<double>::infinity();
  while (count > 0) {
    const Waiting next = waiting[--count];
    if (!(next.distance * next.distance <= nearest)) continue;
    const SegmentCircle& c = g.circles[static_cast<std::size_t>(next.circle)];
    for (int i = c.first; i < c.first + c.count; ++i)
      if (const double d = distance_from(g, i, x, y); d < nearest || (d == nearest && i < found)) {
        nearest = d;
        found = i;
      }
    if (c.count > 0) continue;
    Waiting near{c.first, distance_to(g.circles[static_cast<std::size_t>(c.first)])},
        far{c.first + 1, distance_to(g.circles[static_cast<std::size_t>(c.first) + 1])};
    if (far.distance < near.distance) std::swap(near, far);
    waiting[count++] = far;
    waiting[count++] = near;
  }
  return found;
}

OnSegment on_segment(const GridArrays& g, int i, double x, double y) {
  const double* a = point(g, i);
  const double* b = point(g, i + 1);
  const double dx = b[0] - a[0], dy = b[1] - a[1], length = std::sqrt(dx * dx + dy * dy);
  const double tx = dx / length, ty = dy / length;
  const double turn0 = a[2] * tx + a[3] * ty, turn = b[2] * tx + b[3] * ty - turn0;
  const double px = x - a[0], py = y - a[1], s = px * tx + py * ty;
  OnSegment at;
  at.segment = i;
  at.v = py * tx - px * ty;
  // So far to the inside of a bend that lines of constant u would cross, none of this holds: no road is
  // there.
  const double width = length + at.v * turn, least = 1e-3 * length;
  const bool crossed = !(width > least);
  const double w = crossed ? least : width;
  at.f = (s - at.v * turn0) / w;
  // Derivatives by s and v, then by x and y.
  const double by_s = 1 / w, by_v = -(turn0 + (crossed ? 0 : at.f * turn)) / w,
               by_sv = crossed ? 0 : -turn / (w * w), by_vv = crossed ? 0 : -2 * turn * by_v / w;
  at.vx = -ty;
  at.vy = tx;
  at.fx = by_s * tx + by_v * at.vx;
  at.fy = by_s * ty + by_v * at.vy;
  at.fxx = 2 * by_sv * tx * at.vx + by_vv * at.vx * at.vx;
  at.fxy = by_sv * (tx * at.vy + ty * at.vx) + by_vv * at.vx * at.vy;
  at.fyy = 2 * by_sv * ty * at.vy + by_vv * at.vy * at.vy;
  return at;
}

OnSegment spot(const GridArrays& g, double x, double y) {
  const int segments = points(g) - 1;
  const OnSegment at = on_segment(g, nearest_segment(g, x, y), x, y);
  // In a bend the nearest segment may be the one before or behind that whose mitres the place is between.
  const bool before = at.f < 0;
  if (!before && !(at.f > 1)) return at;
  int next = at.segment + (before ? -1 : 1);
  if (g.closed) next = (next + segments) % segments;
  if (next < 0 || next >= segments) return at;
  const OnSegment neighbour = on_segment(g, next, x, y);
  return (before ? neighbour.f < 1 : neighbour.f > 0) ? neighbour : at;
}

namespace {

/// max(t, 0), rounded over `width` around 0, with derivatives.
struct Ramp {
  double value = 0, first = 0, second = 0;
  Ramp(double t, double width) {
    const double over = t + 0.5 * width;
    if (!(over > 0)) return;
    if (over >= width) {
      value = t;
      first = 1;
      return;
    }
    value = over * over / (2 * width);
    first = over / width;
    second = 1 / width;
  }
};

/// Weights of a grid's line and of its neighbours before and behind it, by the way t from that line; `before`
/// and `behind`: the neighbours' distances.
struct Weights {
  std::array<double, 3> value, first, second;
  Weights(double t, double width, double before, double behind) {
    const Ramp back(-t, width), forth(t, width);
    value[0] = back.value / before;
    value[2] = forth.value / behind;
    value[1] = 1 - value[0] - value[2];
    first[0] = -back.first / before;
    first[2] = forth.first / behind;
    first[1] = -first[0] - first[2];
    second[0] = back.second / before;
    second[2] = forth.second / behind;
    second[1] = -second[0] - second[2];
  }
};

}  // namespace
}  // namespace grid

Height grid_height(const GridArrays& g, double x, double y) {
  using namespace grid;
  constexpr double none = std::numeric_limits<double>::infinity();
  const OnSegment at = spot(g, x, y);
  const int along = points(g), across = static_cast<int>(g.v.size());
  // Beyond an end it goes on level, as to a neighbour of the same heights.
  const double f = std::clamp(at.f, -1.0, 2.0);
  const int row = at.segment + (f > 0.5 ? 1 : 0);
  const int before = row > 0    ? row - 1
                     : g.closed ? along - 2
                                : 0,
            behind = row + 1 < along ? row + 1
                     : g.closed      ? 1
                                     : along - 1;
  const std::array<int, 3> rows{before, row, behind};
  const Weights u(f - (row - at.segment), g.rounding_along[static_cast<std::size_t>(row)], 1, 1);

  const auto v_at = [&](int k) { return g.v[static_cast<std::size_t>(k)]; };
  int section = std::clamp(static_cast<int>(std::upper_bound(g.v.begin(), g.v.end(), at.v) - g.v.begin()) - 1,
                           0, across - 1);
  if (section + 1 < across && at.v - v_at(section) > v_at(section + 1) - at.v) ++section;
  const std::array<int, 3> sections{std::max(section - 1, 0), section, std::min(section + 1, across - 1)};
  // Beside the outer sections it goes on level, as to a neighbour far away.
  const Weights v(at.v - v_at(section), g.rounding_across[static_cast<std::size_t>(section)],
                  section > 0 ? v_at(section) - v_at(section - 1) : none,
                  section + 1 < across ? v_at(section + 1) - v_at(section) : none);

  double z = 0, zu = 0, zv = 0, zuu = 0, zuv = 0, zvv = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double* heights =
        g.height.data() + static_cast<std::ptrdiff_t>(rows[i]) * static_cast<std::ptrdiff_t>(across);
    double here = 0, by_v = 0, by_vv = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      const double height = heights[sections[j]];
      here += v.value[j] * height;
      by_v += v.first[j] * height;
      by_vv += v.second[j] * height;
    }
    z += u.value[i] * here;
    zv += u.value[i] * by_v;
    zvv += u.value[i] * by_vv;
    zu += u.first[i] * here;
    zuv += u.first[i] * by_v;
    zuu += u.second[i] * here;
  }
  Height h;
  h.z = z;
  h.x = zu * at.fx + zv * at.vx;
  h.y = zu * at.fy + zv * at.vy;
  h.xx = zuu * at.fx * at.fx + 2 * zuv * at.fx * at.vx + zvv * at.vx * at.vx + zu * at.fxx;
  h.xy = zuu * at.fx * at.fy + zuv * (at.fx * at.vy + at.fy * at.vx) + zvv * at.vx * at.vy + zu * at.fxy;
  h.yy = zuu * at.fy * at.fy + 2 * zuv * at.fy * at.vy + zvv * at.vy * at.vy + zu * at.fyy;
  return h;
}

bool is_on_road(const GridArrays& g, double x, double y) {
  constexpr double little = 1e-9;  // of a segment, and of m
  const grid::OnSegment at = grid::spot(g, x, y);
  if (!g.closed && !(at.f >= -little && at.f <= 1 + little)) return false;
  const double f = std::clamp(at.f, 0.0, 1.0);
  const auto a = static_cast<std::size_t>(at.segment), b = a + 1;
  return at.v >= g.right[a] + f * (g.right[b] - g.right[a]) - little &&
         at.v <= g.left[a] + f * (g.left[b] - g.left[a]) + little;
}

}  // namespace mimbre::roads
