#include "simulation/step/contact_sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "forces/surfaces/table.h"

namespace mimbre {
namespace {

// As shares of the sphere's radius.
constexpr double graze = 1e-3;       ///< what is not deeper on the way may be passed over
constexpr double deeper = 0.1;       ///< likewise against the depth at an end that touches
constexpr double well_known = 2e-3;  ///< errors of the way that do not matter

constexpr int most_pieces = 64;  ///< chords in place of a way, and samples of one

bool of_triangles(const SurfaceData& surface) { return surface.mesh.nodes.size() > 0; }

/// The least gap on a chord, and where, from its start (0) to its end (1).
struct Lowest {
  double gap = 0, at = 0;
};

/// The distance from a convex solid is a convex function along a straight line: tangents at two points bound
/// it from below. Stops where it is known to stay above `enough`.
Lowest lowest_of_convex(const SurfaceData& surface, double radius, const Vec3d& from, const Vec3d& along,
                        double enough) {
  struct Point {
    double at, gap, slope;
  };
  const auto look = [&](double at) {
    const Touch<double> touch = surfaces::touch(surface, Vec3d(from + at * along));
    return Point{at, touch.distance - radius, touch.normal.dot(along)};
  };
  Point low = look(0), high = look(1);
  Lowest best = low.gap < high.gap ? Lowest{low.gap, 0} : Lowest{high.gap, 1};
  for (int round = 0; round < 60 && low.slope < 0 && high.slope > 0; ++round) {
    const double meet =
        (high.gap - low.gap + low.slope * low.at - high.slope * high.at) / (low.slope - high.slope);
    const double bound = low.gap + low.slope * (meet - low.at);
    if (bound > enough || best.gap - bound < 0.1 * graze * radius) break;
    const double width = high.at - low.at, middle = low.at + 0.5 * width;
    const bool halves = round % 3 == 2 || !(meet > low.at + 1e-3 * width && meet < high.at - 1e-3 * width);
    const Point next = look(halves ? middle : meet);
    if (next.gap < best.gap) best = {next.gap, next.at};
    (next.slope < 0 ? low : high) = next;
  }
  return best;
}

/// Of triangles likewise, of a way that begins outside. A chord that pierces them has the gap −radius.
Lowest lowest_of_triangles(const SurfaceData& surface, double radius, const Vec3d& from, const Vec3d& along,
                           double enough) {
  const NearestOnChord nearest =
      nearest_on_chord(surface.mesh, from, from + along, radius + std::max(enough, 0.0));
  return {nearest.distance - radius, nearest.at};
}

/// The least gap by samples, negative as deep as it goes: of a way that touches triangles at an end.
double lowest_by_samples(const SurfaceData& surface, double radius, const SpherePath& path) {
  const int samples =
      static_cast<int>(std::min(path.longest() / (short_way * radius) + 1, double(most_pieces)));
  double lowest =
      std::min(surfaces::touch(surface, path.from).distance, surfaces::touch(surface, path.to).distance);
  for (int k = 1; k < samples; ++k)
    lowest = std::min(lowest, surfaces::touch(surface, path.at(double(k) / samples)).distance);
  return lowest - radius;
}

/// By how much the sphere comes nearer to the surface in the whole step, at the speed that it has where it
/// meets it: between the start of the chord, where it is free, and `inside`.
double approach(const SurfaceData& surface, double radius, const Vec3d& from, const Vec3d& along,
                double inside) {
  double low = 0, high = inside;
  Touch<double> touch{};
  for (int round = 0; round < 40; ++round) {
    const double middle = 0.5 * (low + high);
    touch = surfaces::touch(surface, Vec3d(from + middle * along));
    (touch.distance - radius < 0 ? high : low) = middle;
  }
  return -touch.normal.dot(along);
}

/// Squared distance between points of two segments, and where it is on the first one (Ericson, Real-Time
/// Collision Detection, 2005, 5.1.9).
double between_segments(const Vec3d& p, const Vec3d& d, const Vec3d& q, const Vec3d& e, double& s) {
  const Vec3d r = p - q;
  const double a = d.dot(d), b = e.dot(e), f = e.dot(r), c = d.dot(r), g = d.dot(e), square = a * b - g * g;
  s = square > 1e-14 * a * b ? std::clamp((g * f - c * b) / square, 0.0, 1.0) : 0.0;
  double t = b > 0 ? (g * s + f) / b : 0.0;
  if (t < 0 || t > 1) {
    t = std::clamp(t, 0.0, 1.0);
    s = a > 0 ? std::clamp((g * t - c) / a, 0.0, 1.0) : 0.0;
  }
  return (r + s * d - t * e).squaredNorm();
}

/// Squared distance of a chord from a triangle.
double from_triangle(const Vec3d& from, const Vec3d& along, const std::array<Vec3d, 3>& v, double& at) {
  const Vec3d normal = (v[1] - v[0]).cross(v[2] - v[0]);
  const double height = normal.dot(from - v[0]), rise = normal.dot(along);
  if (height * (height + rise) <= 0 && rise != 0) {
    at = std::clamp(-height / rise, 0.0, 1.0);
    const Vec3d point = from + at * along;
    bool inside = true;
    for (std::size_t k = 0; k < 3; ++k)
      inside = inside && normal.dot((v[(k + 1) % 3] - v[k]).cross(point - v[k])) >= 0;
    if (inside) return 0;
  }
  int where = 0;
  at = 0;
  double least = (surfaces::nearest_in_triangle(v[0], v[1], v[2], from, where) - from).squaredNorm();
  const Vec3d to = from + along;
  if (const double end = (surfaces::nearest_in_triangle(v[0], v[1], v[2], to, where) - to).squaredNorm();
      end < least) {
    least = end;
    at = 1;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    double s = 0;
    const double edge = between_segments(from, along, v[k], v[(k + 1) % 3] - v[k], s);
    if (edge >= least) continue;
    least = edge;
    at = s;
  }
  return least;
}

/// Whether a chord meets a box that is wider by `most` on all sides.
bool meets(const TriangleMesh::Node& box, const Vec3d& from, const Vec3d& along, double most) {
  double low = 0, high = 1;
  for (int k = 0; k < 3; ++k) {
    double in = box.low[k] - most - from[k], out = box.high[k] + most - from[k];
    if (along[k] == 0) {
      if (in > 0 || out < 0) return false;
      continue;
    }
    in /= along[k];
    out /= along[k];
    if (in > out) std::swap(in, out);
    low = std::max(low, in);
    high = std::min(high, out);
    if (low > high) return false;
  }
  return true;
}

}  // namespace

Vec3d SpherePath::at(double s) const {
  const Vec3d still = from + s * (to - from) - s * (1 - s) * bend;
  return turn.isZero(0) ? still : Vec3d(rotation_exp<double>(Vec3d((1 - s) * turn)) * still);
}

double SpherePath::longest() const {
  return (to - from).norm() + bend.norm() + turn.norm() * std::max(from.norm(), to.norm());
}

NearestOnChord nearest_on_chord(const TriangleMesh& m, const Vec3d& from, const Vec3d& to, double most) {
  std::array<int, 64> waiting;  // as in surfaces::nearest_point
  int count = 0;
  const Vec3d along = to - from;
  NearestOnChord nearest{most, 0};
  waiting[static_cast<std::size_t>(count++)] = 0;
  while (count > 0 && nearest.distance > 0) {
    const TriangleMesh::Node& node =
        m.nodes[static_cast<std::size_t>(waiting[static_cast<std::size_t>(--count)])];
    if (!meets(node, from, along, nearest.distance)) continue;
    if (node.count == 0) {
      waiting[static_cast<std::size_t>(count++)] = node.first + 1;
      waiting[static_cast<std::size_t>(count++)] = node.first;
      continue;
    }
    for (int k = node.first; k < node.first + node.count; ++k) {
      const std::array<int, 3>& t = m.triangles[static_cast<std::size_t>(k)];
      double at = 0;
      const double distance = std::sqrt(from_triangle(
          from, along,
          {m.vertices[static_cast<std::size_t>(t[0])], m.vertices[static_cast<std::size_t>(t[1])],
           m.vertices[static_cast<std::size_t>(t[2])]},
          at));
      if (distance < nearest.distance) nearest = {distance, at};
    }
  }
  return nearest;
}

Passage passage(const SurfaceData& surface, double radius, const SpherePath& path, double before,
                double after, double slow) {
  const bool touches = before < 0 || after < 0;
  if (touches && path.longest() < short_way * radius) return Passage::none;
  if (touches && of_triangles(surface))
    return lowest_by_samples(surface, radius, path) < std::min(before, after) - deeper * radius
               ? Passage::certain
               : Passage::none;
  // So many chords that they lie close to the way.
  const double turn = path.turn.norm(), length = (path.to - path.from).norm() + path.bend.norm(),
               bows = 0.25 * path.bend.norm() + 0.25 * turn * length + 0.125 * turn * turn * path.farthest();
  const int pieces = static_cast<int>(
      std::min(std::ceil(std::sqrt(bows / (0.5 * well_known * radius))) + 1, double(most_pieces)));
  const double bow = bows / (pieces * pieces), unknown = path.error + bow,
               margin = unknown > well_known * radius ? unknown : 0;
  const double floor = touches ? std::min(before, after) - deeper * radius : 0;
  Passage found = Passage::none;
  for (int k = 0; k < pieces; ++k) {
    const Vec3d from = path.at(double(k) / pieces), along = path.at(double(k + 1) / pieces) - from;
    const Lowest lowest = of_triangles(surface)
                              ? lowest_of_triangles(surface, radius, from, along, floor + margin)
                              : lowest_of_convex(surface, radius, from, along, floor + margin);
    if (lowest.gap < floor) {
      if (touches || lowest.gap < -graze * radius ||
          pieces * approach(surface, radius, from, along, lowest.at) > slow)
        return Passage::certain;
    } else if (lowest.gap < floor + margin && !touches) {
      found = Passage::possible;
    }
  }
  return found;
}

}  // namespace mimbre
