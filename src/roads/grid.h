#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "base/array.h"
#include "mimbre/road_file.h"

/// The height of a road over a place, from a grid along a line that may bend. A place's u and v are those of
/// ASAM OpenCRG 1.2, and heights are bilinear between the grid's points, in u and v.
namespace mimbre::roads {

/// Height over global x and y, m, with its derivatives.
struct Height {
  double z = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
};

/// A circle around some of the line's segments, in a tree of them.
struct SegmentCircle {
  double x = 0, y = 0, radius = 0;  ///< m
  int first = 0, count = 0;  ///< segments; of a count of 0: its two halves are at `first` and behind it
};

/// A RoadGrid as a step needs it; constant, so that a height depends on the place alone.
struct GridArrays {
  Array<double> line;            ///< 4 for each point of the line: x, y, and the mitre m (below)
  Array<SegmentCircle> circles;  ///< the root first
  Array<double> v;               ///< places of the long sections, m, growing
  Array<double> height;          ///< of all points, section by section: bank and slope are in them, m
  Array<double> right, left;     ///< v between which heights are known, of each point of the line, m
  /// Widths over which the kinks at the points of the line (in segments) and at the sections (in m) are
  /// rounded.
  Array<double> rounding_along, rounding_across;
  int closed = 0;  ///< 1: the line ends where it begins, and goes on there
};

/// `rounding`: by how much the rounding of kinks along, and of those across, may change a height, m. With 0
/// slopes jump at the grid's lines; with more they are continuous but where the line bends, where they turn
/// with it.
GridArrays arrays_of(const RoadGrid& road, double rounding);

/// A road from a file changes its heights by no more than twice this, m.
constexpr double file_rounding = 4e-5;

namespace grid {

constexpr int line_numbers = 4;

inline int points(const GridArrays& g) { return static_cast<int>(g.line.size()) / line_numbers; }
inline const double* point(const GridArrays& g, int i) { return g.line.data() + i * line_numbers; }

/// Squared distance of a place from the segment behind point i.
inline double distance_from(const GridArrays& g, int i, double x, double y) {
  const double* a = point(g, i);
  const double* b = point(g, i + 1);
  const double tx = b[0] - a[0], ty = b[1] - a[1], px = x - a[0], py = y - a[1];
  const double f = std::clamp((px * tx + py * ty) / (tx * tx + ty * ty), 0.0, 1.0);
  const double ex = px - f * tx, ey = py - f * ty;
  return ex * ex + ey * ey;
}

/// The segment that is nearest to a place, the first of several. Goes down the tree of circles, the nearer
/// half first, past those that lie beyond what was found.
int nearest_segment(const GridArrays& g, double x, double y);

/// A place along and across a segment: f from 0 to 1 along, v to the left, with derivatives by x and y.
///
/// Lines of constant u are straight, from the segment's ends along the mitres m, which halve the angle to the
/// next segment and have length 1 across either; so the lines of constant v are parallel to the segment and
/// meet those of the next. With s, v along and across the segment's first point and τ = m·t:
///
///   s = f L + v (τ₀ + f (τ₁ − τ₀))
struct OnSegment {
  int segment = 0;
  double f = 0, v = 0;
  double fx = 0, fy = 0, vx = 0, vy = 0, fxx = 0, fxy = 0, fyy = 0;
};
OnSegment on_segment(const GridArrays& g, int i, double x, double y);

/// On the segment between whose mitres the place is; before the line's start f < 0, behind its end f > 1.
OnSegment spot(const GridArrays& g, double x, double y);

}  // namespace grid

/// The road under or over (x, y). Beside the outer sections it goes on level from them, in front of its start
/// and behind its end as it is there. Where the road covers a place twice, the part counts whose line is
/// nearer. Allocates nothing.
Height grid_height(const GridArrays& g, double x, double y);

/// Whether the file knows heights around (x, y).
bool is_on_road(const GridArrays& g, double x, double y);

}  // namespace mimbre::roads
