#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "math/dual.h"
#include "math/elementary.h"
#include "math/pack.h"
#include "mimbre/road_file.h"

/// The height of a road over a place, from a grid along a curved line.
namespace mimbre::roads {

/// A RoadGrid as a step needs it. Flat arrays, so that they can be copied elsewhere and seen from there.
struct GridArrays {
  std::vector<double> line;  ///< 6 for each point of the reference line: x, y, mx, my, height, bank
  std::vector<double>
      blocks;             ///< 3 for each block of the line's segments: x, y, radius of a circle around them
  std::vector<double> v;  ///< places of the long sections
  std::vector<double> height;  ///< as RoadGrid::height
  int in_block = 1;            ///< segments in a block
};

/// What evaluation sees of them.
struct GridData {
  const double *line, *blocks, *v, *height;
  int along, across;  ///< points of the line, long sections
  int in_block;       ///< segments in a block: near the root of their number, so that a search takes as many
};

GridArrays arrays_of(const RoadGrid& road);
GridData view_of(const GridArrays& arrays);

/// A global height and its slopes by global x and y.
template <class T>
struct RoadHeight {
  T height, dx, dy;
};

namespace grid {

constexpr int line_numbers = 6, block_numbers = 3;

inline double value_of(double x) { return x; }
inline double value_of(const Dual& x) { return x.value; }

/// Squared distance of a place from the segment behind point i.
inline double distance_from(const GridData& g, int i, double x, double y) {
  const double* a = g.line + i * line_numbers;
  const double* b = a + line_numbers;
  const double tx = b[0] - a[0], ty = b[1] - a[1], px = x - a[0], py = y - a[1];
  const double f = std::clamp((px * tx + py * ty) / (tx * tx + ty * ty), 0.0, 1.0);
  const double ex = px - f * tx, ey = py - f * ty;
  return ex * ex + ey * ey;
}

/// The segment that is nearest to a place. Looks into the block whose circle's centre is nearest, then into
/// those whose circles come nearer than what was found.
inline int nearest_segment(const GridData& g, double x, double y) {
  const int segments = g.along - 1, blocks = (segments + g.in_block - 1) / g.in_block;
  const auto from_centre = [&](int k) {
    const double* block = g.blocks + k * block_numbers;
    const double dx = x - block[0], dy = y - block[1];
    return dx * dx + dy * dy;
  };
  int first = 0;
  double nearest_centre = from_centre(0);
  for (int k = 1; k < blocks; ++k)
    if (const double d = from_centre(k); d < nearest_centre) {
      nearest_centre = d;
      first = k;
    }
  int found = 0;
  double distance = INFINITY;
  const auto look_into = [&](int k) {
    const int end = std::min((k + 1) * g.in_block, segments);
    for (int i = k * g.in_block; i < end; ++i)
      if (const double d = distance_from(g, i, x, y); d < distance) {
        distance = d;
        found = i;
      }
  };
  look_into(first);
  double nearest = std::sqrt(distance);
  for (int k = 0; k < blocks; ++k) {
    const double reach = nearest + g.blocks[k * block_numbers + 2];
    if (k == first || !(from_centre(k) < reach * reach)) continue;
    look_into(k);
    nearest = std::sqrt(distance);
  }
  return found;
}

/// A place along and across a segment: f from 0 to 1 along, v to the left.
///
/// Lines of constant u are straight, from the segment's ends along the mitres m, which halve the angle to the
/// next segment and have length 1 across either; so the lines of constant v are parallel to the segment and
/// meet those of the next. With s, v along and across the segment's first point and τ = m·t:
///
///   s = f L + v (τ₀ + f (τ₁ − τ₀))
template <class T>
struct OnSegment {
  T f, v;
  T fx, fy, vx, vy;  ///< derivatives by x and y
};
template <class T>
OnSegment<T> on_segment(const GridData& g, int i, const T& x, const T& y) {
  const double* a = g.line + i * line_numbers;
  const double* b = a + line_numbers;
  const double length = mimbre::hypot(b[0] - a[0], b[1] - a[1]);
  const double tx = (b[0] - a[0]) / length, ty = (b[1] - a[1]) / length;
  const double turn0 = a[2] * tx + a[3] * ty, turn1 = b[2] * tx + b[3] * ty;
  const T px = x - T(a[0]), py = y - T(a[1]);
  const T s = px * T(tx) + py * T(ty);
  OnSegment<T> at;
  at.v = py * T(tx) - px * T(ty);
  // So far to the inside of a bend that lines of constant u would cross, none of this holds: no road is
  // there.
  const T wide = T(length) + at.v * T(turn1 - turn0);
  const T width = select(wide > T(1e-3 * length), wide, T(1e-3 * length));
  at.f = (s - at.v * T(turn0)) / width;
  const T by_v = T(0) - (T(turn0) + at.f * T(turn1 - turn0)) / width;
  at.vx = T(-ty);
  at.vy = T(tx);
  at.fx = T(tx) / width + by_v * at.vx;
  at.fy = T(ty) / width + by_v * at.vy;
  return at;
}

}  // namespace grid

/// The road under or over (x, y). Beside the outer sections it goes on level from them, in front of its start
/// and behind its end as it is there. Allocates nothing; the search goes through the line's blocks and few of
/// their segments.
template <class T>
RoadHeight<T> road_grid_height(const GridData& g, const T& x, const T& y) {
  using namespace grid;
  int i = nearest_segment(g, value_of(x), value_of(y));
  OnSegment<T> at = on_segment(g, i, x, y);
  // In a bend the nearest segment may be the one before or behind that whose mitres the place is between.
  if (const int next = at.f < T(0)   ? i - 1
                       : at.f > T(1) ? i + 1
                                     : i;
      next != i && next >= 0 && next < g.along - 1) {
    const OnSegment<T> beside = on_segment(g, next, x, y);
    const bool between = next < i ? beside.f < T(1) : beside.f > T(0);
    if (between) {
      i = next;
      at = beside;
    }
  }
  const double* a = g.line + i * line_numbers;
  const double* b = a + line_numbers;
  const T f = at.f < T(0) ? T(0) : at.f > T(1) ? T(1) : at.f;
  const bool inside_u = at.f >= T(0) && at.f <= T(1);
  const T v = at.v < T(g.v[0]) ? T(g.v[0]) : at.v > T(g.v[g.across - 1]) ? T(g.v[g.across - 1]) : at.v;
  const bool inside_v = at.v >= T(g.v[0]) && at.v <= T(g.v[g.across - 1]);
  const int j = std::clamp(static_cast<int>(std::upper_bound(g.v, g.v + g.across, value_of(v)) - g.v) - 1, 0,
                           g.across - 2);
  const double gap = g.v[j + 1] - g.v[j];
  const T w = (v - T(g.v[j])) / T(gap);
  const double* near = g.height + static_cast<std::ptrdiff_t>(i) * g.across + j;
  const double* far = near + g.across;
  const T at_near = T(near[0]) + w * T(near[1] - near[0]), at_far = T(far[0]) + w * T(far[1] - far[0]);
  const T bank = T(a[5]) + f * T(b[5] - a[5]);
  RoadHeight<T> out;
  out.height = at_near + f * (at_far - at_near) + T(a[4]) + f * T(b[4] - a[4]) + bank * v;
  const T by_f = inside_u ? T(at_far - at_near + T(b[4] - a[4]) + v * T(b[5] - a[5])) : T(0);
  const T by_v = inside_v
                     ? T((T(near[1] - near[0]) + f * T(far[1] - far[0] - near[1] + near[0])) / T(gap) + bank)
                     : T(0);
  out.dx = by_f * at.fx + by_v * at.vx;
  out.dy = by_f * at.fy + by_v * at.vy;
  return out;
}

/// Lane by lane: each may be on another place of the road.
template <int N>
RoadHeight<Pack<N>> road_grid_height(const GridData& g, const Pack<N>& x, const Pack<N>& y) {
  RoadHeight<Pack<N>> out;
  for (int lane = 0; lane < N; ++lane) {
    const RoadHeight<double> one = road_grid_height(g, x[lane], y[lane]);
    out.height[lane] = one.height;
    out.dx[lane] = one.dx;
    out.dy[lane] = one.dy;
  }
  return out;
}

}  // namespace mimbre::roads
