#include "fe/surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <utility>

#include "fe/skin.h"

namespace mimbre::fe {
namespace {

using Eigen::Vector3d;
using Corners = std::array<int, 3>;

constexpr double kSharp = 0.866;  ///< cosine of the angle between faces from which an edge is drawn

Vector3d area_of(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  return 0.5 * (b - a).cross(c - a);
}

struct ShellFace {
  Corners nodes;
  double thickness;
};

std::vector<ShellFace> shell_faces(const SolidMesh& mesh) {
  std::vector<ShellFace> faces;
  for (const ElementGroup& group : mesh.groups) {
    if (!is_shell(group.type)) continue;
    const int count = node_count(group.type);
    for (int e = 0; e < group.size(); ++e) {
      const int* const n = group.nodes.data() + e * count;
      const auto add = [&](int a, int b, int c) { faces.push_back({{n[a], n[b], n[c]}, group.thickness}); };
      if (count <= 4) {
        add(0, 1, 2);
        if (count == 4) add(0, 2, 3);
        continue;
      }
      // Corners are cut off between the nodes amid the sides.
      const int corners = count / 2;
      for (int k = 0; k < corners; ++k) add(k, corners + k, corners + (k + corners - 1) % corners);
      for (int k = 2; k < corners; ++k) add(corners, corners + k - 1, corners + k);
    }
  }
  return faces;
}

/// Turns faces over until neighbours face the same side, where that is possible.
void orient(std::vector<ShellFace>& faces) {
  std::map<std::array<int, 2>, std::vector<std::size_t>> at_edge;  // by its ends as the face runs along it
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (int k = 0; k < 3; ++k) at_edge[{faces[f].nodes[k], faces[f].nodes[(k + 1) % 3]}].push_back(f);
  std::vector<int> turned(faces.size(), -1);  // −1: not seen, 0: as it is, 1: turned over
  for (std::size_t seed = 0; seed < faces.size(); ++seed) {
    if (turned[seed] >= 0) continue;
    turned[seed] = 0;
    std::vector<std::size_t> next{seed};
    while (!next.empty()) {
      const std::size_t f = next.back();
      next.pop_back();
      for (int k = 0; k < 3; ++k) {
        const int a = faces[f].nodes[k], b = faces[f].nodes[(k + 1) % 3];
        // Neighbours that face the same side run along the common edge the other way.
        for (const bool same_way : {false, true}) {
          const auto found = at_edge.find(same_way ? std::array{a, b} : std::array{b, a});
          if (found == at_edge.end()) continue;
          for (const std::size_t g : found->second)
            if (turned[g] < 0) {
              turned[g] = same_way ? 1 - turned[f] : turned[f];
              next.push_back(g);
            }
        }
      }
    }
  }
  for (std::size_t f = 0; f < faces.size(); ++f)
    if (turned[f] == 1) std::swap(faces[f].nodes[1], faces[f].nodes[2]);
}

/// Half the thickness along the mean normal, of the nodes of faces that face the same side. Faces that lie on
/// each other may not: where the normals cancel, the first counts.
std::map<int, Vector3d> shell_offsets(const SolidMesh& mesh, const std::vector<ShellFace>& faces) {
  struct Sum {
    Vector3d normal = Vector3d::Zero(), first = Vector3d::Zero();
    double thickness = 0, area = 0;
  };
  std::map<int, Sum> sums;
  for (const auto& [nodes, thickness] : faces) {
    const Vector3d area =
        area_of(mesh.nodes.col(nodes[0]), mesh.nodes.col(nodes[1]), mesh.nodes.col(nodes[2]));
    for (const int node : nodes) {
      Sum& sum = sums[node];
      sum.normal += area;
      if (sum.area == 0) sum.first = area;
      sum.area += area.norm();
      sum.thickness += area.norm() * thickness;
    }
  }
  std::map<int, Vector3d> offsets;
  for (const auto& [node, sum] : sums) {
    const Vector3d& normal = sum.normal.norm() > 1e-6 * sum.area ? sum.normal : sum.first;
    offsets[node] = sum.area > 0 ? Vector3d(0.5 * sum.thickness / sum.area * normal.normalized())
                                 : Vector3d(Vector3d::Zero());
  }
  return offsets;
}

void add_sharp_edges(const SolidMesh& mesh, Surface& surface) {
  struct SharpEdge {
    Vector3d normal = Vector3d::Zero();
    int faces = 0;
    bool sharp = false;
  };
  const auto at = [&](int point) -> Vector3d {
    const SurfacePoint& p = surface.points[static_cast<std::size_t>(point)];
    return mesh.nodes.col(p.node) + p.offset;
  };
  std::map<std::array<int, 2>, SharpEdge> edges;
  for (const Corners& t : surface.triangles) {
    const Vector3d normal = area_of(at(t[0]), at(t[1]), at(t[2])).normalized();
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      SharpEdge& edge = edges[{std::min(a, b), std::max(a, b)}];
      if (edge.faces++ == 0)
        edge.normal = normal;
      else
        edge.sharp = edge.sharp || edge.normal.dot(normal) < kSharp;
    }
  }
  for (const auto& [ends, edge] : edges)
    if (edge.sharp || edge.faces == 1) surface.lines.push_back(ends);
}

}  // namespace

Surface surface(const SolidMesh& mesh) {
  const Skin solids = skin(mesh);
  std::vector<ShellFace> shells = shell_faces(mesh);
  orient(shells);
  const std::map<int, Vector3d> offsets = shell_offsets(mesh, shells);

  std::map<std::pair<int, int>, int> index;  // node and side (0: solids, beams) → point
  for (const Corners& t : solids.triangles)
    for (const int node : t) index[{node, 0}] = 0;
  for (const auto& [node, offset] : offsets) index[{node, 1}] = index[{node, -1}] = 0;
  for (const BeamElement& beam : mesh.beams)
    for (const int node : beam.nodes) index[{node, 0}] = 0;

  Surface out;
  for (auto& [key, place] : index) {
    const auto [node, side] = key;
    place = static_cast<int>(out.points.size());
    out.points.push_back({node, side == 0 ? Vector3d(Vector3d::Zero()) : Vector3d(side * offsets.at(node))});
  }
  const auto point = [&](int node, int side) { return index.at({node, side}); };
  for (const auto& [a, b, c] : solids.triangles)
    out.triangles.push_back({point(a, 0), point(b, 0), point(c, 0)});
  for (const auto& [nodes, thickness] : shells) {
    const auto& [a, b, c] = nodes;
    out.triangles.push_back({point(a, 1), point(b, 1), point(c, 1)});
    out.triangles.push_back({point(a, -1), point(c, -1), point(b, -1)});
  }
  add_sharp_edges(mesh, out);
  for (const BeamElement& beam : mesh.beams)
    out.lines.push_back({point(beam.nodes[0], 0), point(beam.nodes[1], 0)});
  return out;
}

}  // namespace mimbre::fe
