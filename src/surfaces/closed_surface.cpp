#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <tuple>

#include "mimbre/surface_mesh.h"

namespace mimbre {
namespace {

/// A triangle's side, by its lower and higher vertex, and whether the triangle runs along it upwards.
struct Side {
  int low, high;
  bool up;
};

std::vector<Side> sorted_sides(const std::vector<std::array<int, 3>>& triangles) {
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (const auto& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = t[k], to = t[(k + 1) % 3];
      sides.push_back({std::min(from, to), std::max(from, to), from < to});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.up) < std::tie(b.low, b.high, b.up);
  });
  return sides;
}

std::string to_text(const Eigen::Vector3d& p) {
  return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", p.x(), p.y(), p.z());
}

}  // namespace

std::string why_not_closed(const SurfaceMesh& mesh) {
  if (mesh.triangles.empty()) return "it has no triangles";
  const std::vector<Side> sides = sorted_sides(mesh.triangles);
  struct Fault {
    int count = 0;
    const Side* first = nullptr;
    void add(const Side& side) {
      if (count++ == 0) first = &side;
    }
  } open, many, same;
  for (std::size_t at = 0, end = 0; at < sides.size(); at = end) {
    while (end < sides.size() && sides[end].low == sides[at].low && sides[end].high == sides[at].high) ++end;
    const auto up = std::count_if(sides.begin() + static_cast<std::ptrdiff_t>(at),
                                  sides.begin() + static_cast<std::ptrdiff_t>(end),
                                  [](const Side& side) { return side.up; });
    if (end - at == 1)
      open.add(sides[at]);
    else if (end - at > 2)
      many.add(sides[at]);
    else if (up != 1)
      same.add(sides[at]);
  }
  const auto from_to = [&](const Fault& fault) {
    return fmt::format("from {} to {}", to_text(mesh.vertices.col(fault.first->low)),
                       to_text(mesh.vertices.col(fault.first->high)));
  };
  if (open.count > 0)
    return fmt::format("it has a hole: {} of its edges belong to one triangle only, for example that {}",
                       open.count, from_to(open));
  if (many.count > 0)
    return fmt::format("{} of its edges belong to more than two triangles, for example that {}", many.count,
                       from_to(many));
  if (same.count > 0)
    return fmt::format(
        "at {} of its edges one triangle faces outwards and the other inwards, for example at that {}",
        same.count, from_to(same));
  if (!(enclosed_volume(mesh) > 0)) return "its triangles face inwards, or it encloses no volume";
  return {};
}

double enclosed_volume(const SurfaceMesh& mesh) {
  if (mesh.vertices.cols() == 0) return 0;
  const Eigen::Vector3d centre = mesh.vertices.rowwise().mean();
  double six = 0;
  for (const auto& [p, q, r] : mesh.triangles)
    six += (mesh.vertices.col(p) - centre)
               .dot((mesh.vertices.col(q) - centre).cross(mesh.vertices.col(r) - centre));
  return six / 6;
}

}  // namespace mimbre
