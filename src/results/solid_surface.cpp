#include "results/solid_surface.h"

#include <cmath>
#include <numbers>

#include "math/elementary.h"

namespace mimbre::results {
namespace {

using Eigen::Vector3d;

/// Points on circles about z, one above the other, from the bottom to the top; a circle of radius 0 is one
/// point.
struct Ring {
  double radius, height;
};

struct Surface {
  std::vector<Vector3d> points;
  std::vector<std::array<int, 3>> triangles;
};

/// Counterclockwise from outside. `offset`: of the first corner from x, in corners.
Surface turned_surface(const std::vector<Ring>& rings, int corners, double offset = 0) {
  Surface out;
  std::vector<std::vector<int>> numbers;
  for (const Ring& ring : rings) {
    std::vector<int>& own = numbers.emplace_back();
    const int count = ring.radius > 0 ? corners : 1;
    for (int k = 0; k < count; ++k) {
      const double angle = 2 * std::numbers::pi * (k + offset) / corners;
      own.push_back(static_cast<int>(out.points.size()));
      out.points.emplace_back(ring.radius * mimbre::cos(angle), ring.radius * mimbre::sin(angle),
                              ring.height);
    }
    own.resize(static_cast<std::size_t>(corners), own.front());
  }
  for (std::size_t r = 0; r + 1 < numbers.size(); ++r)
    for (std::size_t k = 0; k < static_cast<std::size_t>(corners); ++k) {
      const std::size_t next = (k + 1) % static_cast<std::size_t>(corners);
      const int a = numbers[r][k], b = numbers[r][next], c = numbers[r + 1][next], d = numbers[r + 1][k];
      if (a != b) out.triangles.push_back({a, b, c});
      if (c != d) out.triangles.push_back({a, c, d});
    }
  return out;
}

Surface surface_of(const spec::Shape& shape, int around) {
  const int circles = around / 2;
  const Vector3d& size = shape.size;
  if (shape.kind == spec::Shape::Kind::cylinder) {
    const double r = size[0], h = 0.5 * size[1];
    // Each end has points of its own, so that the edge is sharp.
    return turned_surface({{0, -h}, {r, -h}, {r, -h}, {r, h}, {r, h}, {0, h}}, around);
  }
  if (shape.kind == spec::Shape::Kind::sphere) {
    std::vector<Ring> rings;
    for (int k = 0; k <= circles; ++k) {
      const double angle = std::numbers::pi * k / circles;
      rings.push_back(
          {k == 0 || k == circles ? 0 : size[0] * mimbre::sin(angle), -size[0] * mimbre::cos(angle)});
    }
    return turned_surface(rings, around);
  }
  // A cylinder of four corners, with the edges 1.
  const double r = std::sqrt(0.5);
  Surface box = turned_surface({{0, -0.5}, {r, -0.5}, {r, -0.5}, {r, 0.5}, {r, 0.5}, {0, 0.5}}, 4, 0.5);
  for (Vector3d& point : box.points) point = point.cwiseProduct(size);
  return box;
}

}  // namespace

void add_solids(BodyDrawing& body, int around) {
  for (const spec::Shape& shape : body.shapes) {
    if (shape.kind == spec::Shape::Kind::mesh) continue;
    const Surface surface = surface_of(shape, around);
    const Eigen::Index before = body.points.cols(), added = std::ssize(surface.points);
    body.points.conservativeResize(3, before + added);
    for (Eigen::Index k = 0; k < added; ++k)
      body.points.col(before + k) =
          shape.pose.rotation * surface.points[static_cast<std::size_t>(k)] + shape.pose.position;
    body.point_shapes.conservativeResize(3 * (before + added), Eigen::NoChange);
    body.point_shapes.bottomRows(3 * added).setZero();
    const int first = static_cast<int>(before);
    for (const auto& [a, b, c] : surface.triangles)
      body.triangles.push_back({first + a, first + b, first + c});
  }
  body.shapes.clear();
}

}  // namespace mimbre::results
