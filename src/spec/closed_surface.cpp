#include "spec/closed_surface.h"

#include <fmt/format.h>

namespace mimbre {
namespace {

std::size_t place(int index) { return static_cast<std::size_t>(index); }

}  // namespace

Vec3<double> doubled_area(const std::vector<Vec3<double>>& v, const Triangle& t) {
  return (v[place(t[1])] - v[place(t[0])]).cross(v[place(t[2])] - v[place(t[0])]);
}

std::map<std::array<int, 2>, std::array<int, 2>> edges_of(const std::vector<Triangle>& triangles) {
  std::map<std::array<int, 2>, std::array<int, 2>> edges;
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
    for (int k = 0; k < 3; ++k)
      edges.insert({{triangles[place(t)][place(k)], triangles[place(t)][place((k + 1) % 3)]}, {t, k}});
  return edges;
}

std::string why_not_closed(const std::vector<Vec3<double>>& vertices,
                           const std::vector<Triangle>& triangles) {
  if (triangles.size() < 4)
    return fmt::format("has {} triangles; a closed surface has at least 4", triangles.size());
  for (std::size_t k = 0; k < triangles.size(); ++k)
    for (const int v : triangles[k])
      if (v < 0 || v >= static_cast<int>(vertices.size()))
        return fmt::format("triangle {} has vertex {}, but there are {} (counted from 0)", k, v,
                           vertices.size());
  double volume = 0;
  for (std::size_t k = 0; k < triangles.size(); ++k) {
    const Vec3<double> area = doubled_area(vertices, triangles[k]);
    if (!(area.norm() > 0)) return fmt::format("triangle {} has no area; leave it out", k);
    volume += area.dot(vertices[place(triangles[k][0])] - vertices[place(triangles[0][0])]) / 6;
  }
  const auto edges = edges_of(triangles);
  if (edges.size() != 3 * triangles.size())
    return "has an edge that two triangles run along in the same direction: all must be counterclockwise "
           "from "
           "outside, and none may come twice";
  for (const auto& [edge, from] : edges)
    if (!edges.contains({edge[1], edge[0]}))
      return fmt::format("is not closed: triangle {} has none beside it at its edge from vertex {} to {}",
                         from[0], edge[0], edge[1]);
  if (!(volume > 0)) return "is inside out: its triangles have to be counterclockwise from outside";
  return {};
}

}  // namespace mimbre
