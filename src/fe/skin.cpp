#include "fe/skin.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace mimbre::fe {
namespace {

/// Corner faces of the solids, outwards; −1: a triangle.
using Face = std::array<int, 4>;
const std::vector<Face>& faces_of(ElementType type) {
  static const std::vector<Face> tet{{0, 2, 1, -1}, {0, 1, 3, -1}, {1, 2, 3, -1}, {0, 3, 2, -1}};
  static const std::vector<Face> hex{{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                     {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  static const std::vector<Face> wedge{
      {0, 2, 1, -1}, {3, 4, 5, -1}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}};
  static const std::vector<Face> triangle{{0, 1, 2, -1}}, quadrilateral{{0, 1, 2, 3}};
  switch (type) {
    case ElementType::tet4:
    case ElementType::tet10:
      return tet;
    case ElementType::hex8:
    case ElementType::hex20:
      return hex;
    case ElementType::wedge6:
    case ElementType::wedge15:
      return wedge;
    case ElementType::tri3:
      return triangle;
    case ElementType::quad4:
      break;
  }
  return quadrilateral;
}

}  // namespace

Skin skin(const SolidMesh& mesh) {
  Skin out;
  std::vector<std::pair<Face, Face>> solids;  // sorted corners, and in order
  std::vector<Face> faces;
  for (const ElementGroup& group : mesh.groups) {
    const int count = node_count(group.type);
    for (int e = 0; e < group.size(); ++e)
      for (const Face& face : faces_of(group.type)) {
        Face nodes{};
        for (std::size_t k = 0; k < 4; ++k)
          nodes[k] = face[k] < 0 ? -1 : group.nodes[static_cast<std::size_t>(e * count + face[k])];
        if (is_shell(group.type)) {
          faces.push_back(nodes);
          out.closed = false;
          continue;
        }
        Face key = nodes;
        std::sort(key.begin(), key.end());
        solids.emplace_back(key, nodes);
      }
  }
  out.closed = out.closed && mesh.beams.empty() && !solids.empty();
  std::sort(solids.begin(), solids.end());
  for (std::size_t k = 0; k < solids.size();) {
    std::size_t next = k + 1;
    while (next < solids.size() && solids[next].first == solids[k].first) ++next;
    if (next == k + 1) faces.push_back(solids[k].second);
    k = next;
  }
  for (const Face& f : faces) {
    const int corners = f[3] < 0 ? 3 : 4;
    out.triangles.push_back({f[0], f[1], f[2]});
    if (corners == 4) out.triangles.push_back({f[0], f[2], f[3]});
    for (int k = 0; k < corners; ++k) {
      const int a = f[static_cast<std::size_t>(k)], b = f[static_cast<std::size_t>((k + 1) % corners)];
      out.edges.push_back({std::min(a, b), std::max(a, b)});
    }
  }
  for (const BeamElement& beam : mesh.beams)
    out.edges.push_back({std::min(beam.nodes[0], beam.nodes[1]), std::max(beam.nodes[0], beam.nodes[1])});
  std::sort(out.edges.begin(), out.edges.end());
  out.edges.erase(std::unique(out.edges.begin(), out.edges.end()), out.edges.end());
  return out;
}

Enclosed enclosed(const SolidMesh& mesh, const Skin& skin) {
  Enclosed out;
  for (const auto& t : skin.triangles) {
    const Eigen::Vector3d a = mesh.nodes.col(t[0]), b = mesh.nodes.col(t[1]), c = mesh.nodes.col(t[2]);
    const double volume = a.dot(b.cross(c)) / 6;
    out.volume += volume;
    out.centre += volume * (a + b + c) / 4;
  }
  if (out.volume != 0) out.centre /= out.volume;
  return out;
}

Wire wire(const SolidMesh& mesh, const Skin& skin, int most) {
  std::set<int> used;
  for (const auto& edge : skin.edges) used.insert(edge.begin(), edge.end());
  if (used.empty()) return {};
  Eigen::Vector3d low = mesh.nodes.col(*used.begin()), high = low;
  for (const int node : used) {
    low = low.cwiseMin(mesh.nodes.col(node));
    high = high.cwiseMax(mesh.nodes.col(node));
  }
  const double size = (high - low).maxCoeff();
  // The skin of a body fills about the square of its cells per edge.
  double cell = static_cast<int>(used.size()) <= most ? 0 : size / std::sqrt(most);
  while (true) {
    std::map<std::array<int, 3>, int> nodes;  // cell → index
    std::map<int, int> index;                 // node → index
    Wire out;
    for (const int node : used) {
      if (cell == 0) {
        index[node] = static_cast<int>(out.nodes.size());
        out.nodes.push_back(node);
        continue;
      }
      const Eigen::Vector3d r = (mesh.nodes.col(node) - low) / cell;
      const auto [found, fresh] =
          nodes.try_emplace({static_cast<int>(r.x()), static_cast<int>(r.y()), static_cast<int>(r.z())},
                            static_cast<int>(out.nodes.size()));
      if (fresh) out.nodes.push_back(node);
      index[node] = found->second;
    }
    std::set<std::array<int, 2>> lines;
    for (const auto& [a, b] : skin.edges) {
      const int i = index[a], j = index[b];
      if (i != j) lines.insert({std::min(i, j), std::max(i, j)});
    }
    out.lines.assign(lines.begin(), lines.end());
    if (static_cast<int>(out.nodes.size()) <= most) return out;
    cell *= 1.4;
  }
}

}  // namespace mimbre::fe
