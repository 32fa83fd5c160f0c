#include "results/thin_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace mimbre::results {
namespace {

using Line = std::array<int, 2>;
using Triangle = std::array<int, 3>;
using Eigen::Vector3d;

constexpr double kSharp = 0.8660254037844386;  // cosine of 30°

Line ascending(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

void make_unique(std::vector<Line>& lines) {
  std::sort(lines.begin(), lines.end());
  lines.erase(std::unique(lines.begin(), lines.end()), lines.end());
}

Vector3d area(const Eigen::Matrix3Xd& points, const Triangle& t) {
  const Vector3d first = points.col(t[0]);
  return (points.col(t[1]) - first).cross(points.col(t[2]) - first);
}

/// A triangle at one of its edges.
struct Side {
  Line edge;
  std::size_t triangle;
  bool forwards;  ///< it runs along the edge from the smaller number
};

std::vector<Side> sides_of(const std::vector<Triangle>& triangles) {
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      sides.push_back({ascending(a, b), t, a < b});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.edge < b.edge; });
  return sides;
}

/// Where a surface's edges end, meet or turn.
std::vector<int> corners_of(const Eigen::Matrix3Xd& points, const std::vector<Line>& edges) {
  std::map<int, std::vector<int>> neighbours;
  for (const auto& [a, b] : edges) {
    neighbours[a].push_back(b);
    neighbours[b].push_back(a);
  }
  std::vector<int> corners;
  for (const auto& [point, others] : neighbours) {
    const Vector3d place = points.col(point);
    const auto towards = [&](int other) -> Vector3d { return (points.col(other) - place).normalized(); };
    if (others.size() != 2 || towards(others[0]).dot(towards(others[1])) > -kSharp) corners.push_back(point);
  }
  return corners;
}

/// What keeps points of one cell apart: 0 to 5 the direction that the surface faces there, 6 its edges, 7
/// their corners, 8 what only lines have; -1: nothing has it.
std::vector<int> kinds_of(const Eigen::Matrix3Xd& points, const std::vector<Triangle>& triangles,
                          const std::vector<Line>& lines, const std::vector<Line>& edges) {
  std::vector<int> kinds(static_cast<std::size_t>(points.cols()), -1);
  const auto kind = [&](int point) -> int& { return kinds[static_cast<std::size_t>(point)]; };
  for (const Line& line : lines)
    for (const int point : line) kind(point) = 8;
  Eigen::Matrix3Xd normals = Eigen::Matrix3Xd::Zero(3, points.cols());
  for (const Triangle& t : triangles) {
    const Vector3d normal = area(points, t);
    for (const int point : t) normals.col(point) += normal;
  }
  for (const Triangle& t : triangles)
    for (const int point : t) {
      Eigen::Index axis = 0;
      const double largest = normals.col(point).cwiseAbs().maxCoeff(&axis);
      kind(point) = static_cast<int>(2 * axis) + (largest > 0 && normals(axis, point) < 0);
    }
  for (const Line& edge : edges)
    for (const int point : edge) kind(point) = 6;
  for (const int point : corners_of(points, edges)) kind(point) = 7;
  return kinds;
}

using Cell = std::array<int, 4>;

/// Along one axis; what is not finite has to be somewhere.
int cell_of(double place) { return std::isfinite(place) ? static_cast<int>(place) : 0; }

/// The point that takes the place of each; −1 where nothing has the point.
std::vector<int> clustered(const Eigen::Matrix3Xd& points, const std::vector<int>& kinds, const Vector3d& low,
                           double size, const Eigen::Ref<const Eigen::VectorXd>& weights) {
  std::map<Cell, int> kept;
  std::vector<Cell> cells(kinds.size());
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    if (kinds[k] < 0) continue;
    const int point = static_cast<int>(k);
    const Vector3d place = (points.col(point) - low) / size;
    cells[k] = {cell_of(place.x()), cell_of(place.y()), cell_of(place.z()), kinds[k]};
    int& best = kept.try_emplace(cells[k], point).first->second;
    if (weights.size() > 0 && weights(point) > weights(best)) best = point;
  }
  std::vector<int> stands_for(kinds.size(), -1);
  for (std::size_t k = 0; k < kinds.size(); ++k)
    if (kinds[k] >= 0) stands_for[k] = kept.at(cells[k]);
  return stands_for;
}

std::vector<int> places(const std::vector<int>& stands_for, std::vector<int>& kept) {
  kept = stands_for;
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  if (!kept.empty() && kept.front() < 0) kept.erase(kept.begin());
  std::vector<int> place(stands_for.size(), -1);
  for (std::size_t k = 0; k < stands_for.size(); ++k)
    if (stands_for[k] >= 0)
      place[k] = static_cast<int>(std::lower_bound(kept.begin(), kept.end(), stands_for[k]) - kept.begin());
  return place;
}

std::vector<Line> moved(const std::vector<Line>& lines, const std::vector<int>& place) {
  std::vector<Line> out;
  for (const auto& [a, b] : lines) {
    const int i = place[static_cast<std::size_t>(a)], j = place[static_cast<std::size_t>(b)];
    if (i != j) out.push_back(ascending(i, j));
  }
  make_unique(out);
  return out;
}

/// Without those that lost their extent, and one of those that have come to lie on each other.
std::vector<Triangle> moved(const std::vector<Triangle>& triangles, const std::vector<int>& place) {
  std::vector<std::pair<Triangle, Triangle>> sorted;  // corners ascending, and in their order
  for (const Triangle& t : triangles) {
    Triangle corners{};
    for (std::size_t k = 0; k < 3; ++k) corners[k] = place[static_cast<std::size_t>(t[k])];
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    Triangle key = corners;
    std::sort(key.begin(), key.end());
    sorted.emplace_back(key, corners);
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<Triangle> out;
  for (std::size_t k = 0; k < sorted.size(); ++k)
    if (k == 0 || sorted[k].first != sorted[k - 1].first) out.push_back(sorted[k].second);
  return out;
}

}  // namespace

std::vector<Line> feature_edges(const Eigen::Matrix3Xd& points, const std::vector<Triangle>& triangles) {
  const std::vector<Side> sides = sides_of(triangles);
  std::vector<Line> edges;
  for (std::size_t k = 0; k < sides.size();) {
    std::size_t next = k + 1;
    while (next < sides.size() && sides[next].edge == sides[k].edge) ++next;
    bool feature = next != k + 2;
    if (!feature) {
      // Neighbours that face the same way run along their edge in opposite directions.
      const double sign = sides[k].forwards == sides[k + 1].forwards ? -1 : 1;
      const Vector3d a = area(points, triangles[sides[k].triangle]),
                     b = area(points, triangles[sides[k + 1].triangle]);
      feature = sign * a.dot(b) < kSharp * a.norm() * b.norm();
    }
    if (feature) edges.push_back(sides[k].edge);
    k = next;
  }
  return edges;
}

std::vector<Line> free_lines(const std::vector<Line>& lines, const std::vector<Triangle>& triangles) {
  if (triangles.empty()) return lines;
  std::vector<Line> edges;
  for (const Side& side : sides_of(triangles)) edges.push_back(side.edge);
  std::vector<Line> out;
  for (const Line& line : lines)
    if (!std::binary_search(edges.begin(), edges.end(), ascending(line[0], line[1]))) out.push_back(line);
  return out;
}

ThinSurface thin_surface(const Eigen::Matrix3Xd& points, const std::vector<Triangle>& triangles,
                         const std::vector<Line>& lines, int most,
                         const Eigen::Ref<const Eigen::VectorXd>& weights) {
  ThinSurface out;
  out.edges = feature_edges(points, triangles);
  if (points.cols() <= most) {
    out.points.resize(static_cast<std::size_t>(points.cols()));
    std::iota(out.points.begin(), out.points.end(), 0);
    out.triangles = triangles;
    out.lines = lines;
    return out;
  }
  const std::vector<int> kinds = kinds_of(points, triangles, lines, out.edges);
  std::vector<int> stands_for(kinds.size(), -1);
  Vector3d low = Vector3d::Constant(INFINITY), high = -low;
  bool any = false;
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    if (kinds[k] < 0) continue;
    stands_for[k] = static_cast<int>(k);
    if (!points.col(stands_for[k]).allFinite()) continue;
    any = true;
    low = low.cwiseMin(points.col(stands_for[k]));
    high = high.cwiseMax(points.col(stands_for[k]));
  }
  const double size = any ? (high - low).maxCoeff() : 0;
  std::vector<int> place = places(stands_for, out.points);
  // A surface fills about the square of its cells per edge, and the points of a cell are of at most nine
  // kinds: it ends with one cell.
  for (double cell = size > 0 ? size / std::sqrt(most) : 1; static_cast<int>(out.points.size()) > most;
       cell *= 1.2)
    place = places(clustered(points, kinds, low, cell, weights), out.points);
  out.triangles = moved(triangles, place);
  out.lines = moved(lines, place);
  out.edges = moved(out.edges, place);
  return out;
}

}  // namespace mimbre::results
