#pragma once
#include <algorithm>
#include <array>
#include <cmath>

#include "compile/compiled.h"
#include "math/function_values.h"
#include "math/rotation.h"

/// Roads as wheels feel them: heights and slopes that are continuous, so that a spring on them keeps its
/// energy and nothing jumps where the road has a corner. A profile is felt along a footprint: its height is
/// the mean over it, and so the slope is the difference of its ends over its length, which is the derivative
/// of that mean. A grid is the biquadratic B-spline of its heights, the mean of its bilinear surface over
/// one cell: planes stay what they are, edges are rounded over a cell. One along a line (roads/grid.h) is
/// bilinear, with edges rounded only a little.
namespace mimbre::roads {

/// Weights of three neighbours of a quadratic B-spline, with derivatives by the place among cells, at
/// 0 ≤ t ≤ 1 between the middles of the two cells around the one in the middle.
struct SplineWeights {
  std::array<double, 3> value, first;
  static constexpr std::array<double, 3> second{1, -2, 1};
  explicit SplineWeights(double t)
      : value{0.5 * (1 - t) * (1 - t), 0.5 + t * (1 - t), 0.5 * t * t}, first{t - 1, 1 - 2 * t, t} {}
};

/// Calls add(weights along x, weights along y, i, j, z) for the nine heights around a place.
template <class Add>
void visit_grid(const RoadData& road, double x, double y, const Add& add) {
  const std::array<double, 2> place{x, y};
  const std::array<int, 2> counts{road.columns, road.rows};
  int near[2] = {};
  double within[2] = {};
  for (std::size_t k = 0; k < 2; ++k) {
    // A cell beyond the border all is level; a place that is no number is taken as there.
    const double u = (place[k] - road.origin[k]) / road.spacing[k] + 0.5;
    const double kept = u > -1 ? std::min(u, counts[k] + 1.0) : -1;
    near[k] = static_cast<int>(std::floor(kept));
    within[k] = kept - near[k];
  }
  const SplineWeights wx(within[0]), wy(within[1]);
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) {
      const int column = std::clamp(near[0] + i - 1, 0, road.columns - 1),
                row = std::clamp(near[1] + j - 1, 0, road.rows - 1);
      add(wx, wy, static_cast<std::size_t>(i), static_cast<std::size_t>(j),
          road.heights[static_cast<std::size_t>(row) * static_cast<std::size_t>(road.columns) +
                       static_cast<std::size_t>(column)]);
    }
}

inline Height grid_height(const RoadData& road, double x, double y) {
  Height h;
  visit_grid(road, x, y,
             [&](const SplineWeights& wx, const SplineWeights& wy, std::size_t a, std::size_t b, double z) {
               h.z += wx.value[a] * wy.value[b] * z;
               h.x += wx.first[a] * wy.value[b] * z;
               h.y += wx.value[a] * wy.first[b] * z;
               h.xx += SplineWeights::second[a] * wy.value[b] * z;
               h.xy += wx.first[a] * wy.first[b] * z;
               h.yy += wx.value[a] * SplineWeights::second[b] * z;
             });
  const double dx = road.spacing[0], dy = road.spacing[1];
  return {h.z, h.x / dx, h.y / dy, h.xx / (dx * dx), h.xy / (dx * dy), h.yy / (dy * dy)};
}

/// `footprint`: half its length, m.
inline Height profile_height(const FunctionData& profile, double footprint, double x) {
  const double front = x + footprint, back = x - footprint, length = 2 * footprint;
  const auto [high, rise] = profile.tangent(front);
  const auto [low, fall] = profile.tangent(back);
  Height h;
  h.z = (profile.antiderivative(front) - profile.antiderivative(back)) / length;
  h.x = (high - low) / length;
  h.xx = (rise - fall) / length;
  return h;
}

/// 0 of a road over time.
inline Height height(const RoadData& road, double footprint, double x, double y) {
  switch (road.over) {
    case spec::Road::Over::distance:
      return profile_height(road.height, footprint, x);
    case spec::Road::Over::grid:
      return road.along_line() ? grid_height(road.own, x, y) : grid_height(road, x, y);
    case spec::Road::Over::time:
      break;
  }
  return {};
}

/// Factor on the friction of tyres.
inline double friction(const RoadData& road, double x, double y) {
  double factor = road.friction;
  for (const RoadData::Patch& p : road.patches)
    if (x >= p.low[0] && x <= p.high[0] && y >= p.low[1] && y <= p.high[1]) factor = p.friction;
  return factor;
}

/// A place of a road for any scalar.
template <class T>
struct Place {
  T z, slope_x, slope_y, friction;
};

inline Place<double> place(const RoadData& road, double footprint, double x, double y) {
  const Height h = height(road, footprint, x, y);
  return {h.z, h.x, h.y, friction(road, x, y)};
}
inline Place<Dual> place(const RoadData& road, double footprint, const Dual& x, const Dual& y) {
  const Height h = height(road, footprint, x.value, y.value);
  const auto chain = [&](double f, double by_x, double by_y) {
    return Dual::chain(f, by_x, x) + Dual::chain(0, by_y, y);
  };
  return {chain(h.z, h.x, h.y), chain(h.x, h.xx, h.xy), chain(h.y, h.xy, h.yy),
          Dual(friction(road, x.value, y.value))};
}
template <int N>
Place<Pack<N>> place(const RoadData& road, double footprint, const Pack<N>& x, const Pack<N>& y) {
  Place<Pack<N>> out;
  for (int i = 0; i < N; ++i) {
    const Place<double> lane = place(road, footprint, x[i], y[i]);
    out.z[i] = lane.z;
    out.slope_x[i] = lane.slope_x;
    out.slope_y[i] = lane.slope_y;
    out.friction[i] = lane.friction;
  }
  return out;
}

/// Of a road over time too; `signals`: all slots.
template <class T>
Place<T> place(const RoadData& road, double footprint, const T& x, const T& y, const T* signals) {
  Place<T> at = place(road, footprint, x, y);
  if (road.over == spec::Road::Over::time) at.z = signals[road.slot];
  return at;
}

/// The height of a road over a grid, m, with its first and second derivatives by x and y.
template <class T>
struct Bend {
  T z, x, y, xx, xy, yy;
};
inline Bend<double> bend(const RoadData& road, double x, double y) {
  const Height h = grid_height(road, x, y);
  return {h.z, h.x, h.y, h.xx, h.xy, h.yy};
}
/// Within a cell third derivatives by x, or by y, alone vanish.
inline Bend<Dual> bend(const RoadData& road, const Dual& x, const Dual& y) {
  const Height h = grid_height(road, x.value, y.value);
  double xxy = 0, xyy = 0;
  visit_grid(road, x.value, y.value,
             [&](const SplineWeights& wx, const SplineWeights& wy, std::size_t a, std::size_t b, double z) {
               xxy += SplineWeights::second[a] * wy.first[b] * z;
               xyy += wx.first[a] * SplineWeights::second[b] * z;
             });
  const double dx = road.spacing[0], dy = road.spacing[1];
  xxy /= dx * dx * dy;
  xyy /= dx * dy * dy;
  const auto chain = [&](double f, double by_x, double by_y) {
    return Dual(f, by_x * x.derivative + by_y * y.derivative);
  };
  return {chain(h.z, h.x, h.y), chain(h.x, h.xx, h.xy), chain(h.y, h.xy, h.yy),
          chain(h.xx, 0, xxy),  chain(h.xy, xxy, xyy),  chain(h.yy, xyy, 0)};
}
template <int N>
Bend<Pack<N>> bend(const RoadData& road, const Pack<N>& x, const Pack<N>& y) {
  Bend<Pack<N>> out;
  for (int i = 0; i < N; ++i) {
    const Bend<double> lane = bend(road, x[i], y[i]);
    out.z[i] = lane.z;
    out.x[i] = lane.x;
    out.y[i] = lane.y;
    out.xx[i] = lane.xx;
    out.xy[i] = lane.xy;
    out.yy[i] = lane.yy;
  }
  return out;
}

template <class T>
Vec3<T> normal(const Place<T>& at) {
  using std::sqrt;
  const T size = sqrt(T(1) + at.slope_x * at.slope_x + at.slope_y * at.slope_y);
  return {-at.slope_x / size, -at.slope_y / size, T(1) / size};
}

}  // namespace mimbre::roads
