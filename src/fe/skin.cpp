#include "fe/skin.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>
#include <utility>

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
  static const std::vector<Face> pyramid{
      {0, 3, 2, 1}, {0, 1, 4, -1}, {1, 2, 4, -1}, {2, 3, 4, -1}, {3, 0, 4, -1}};
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
    case ElementType::pyramid5:
    case ElementType::pyramid13:
      return pyramid;
    default:
      throw std::logic_error("a shell has no outer faces");
  }
}

}  // namespace

Skin skin(const SolidMesh& mesh) {
  Skin out;
  std::vector<std::pair<Face, Face>> solids;  // sorted corners, and in order
  out.closed = mesh.beams.empty();
  for (const ElementGroup& group : mesh.groups) {
    if (is_shell(group.type)) {
      out.closed = out.closed && group.nodes.empty();
      continue;
    }
    const int count = node_count(group.type);
    for (int e = 0; e < group.size(); ++e)
      for (const Face& face : faces_of(group.type)) {
        Face nodes{};
        for (std::size_t k = 0; k < 4; ++k)
          nodes[k] = face[k] < 0 ? -1 : group.nodes[static_cast<std::size_t>(e * count + face[k])];
        Face key = nodes;
        std::sort(key.begin(), key.end());
        solids.emplace_back(key, nodes);
      }
  }
  out.closed = out.closed && !solids.empty();
  const auto add = [&](const Face& f) {
    out.triangles.push_back({f[0], f[1], f[2]});
    if (f[3] >= 0) out.triangles.push_back({f[0], f[2], f[3]});
  };
  std::sort(solids.begin(), solids.end());
  for (std::size_t k = 0; k < solids.size();) {
    std::size_t next = k + 1;
    while (next < solids.size() && solids[next].first == solids[k].first) ++next;
    if (next == k + 1) add(solids[k].second);
    k = next;
  }
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

}  // namespace mimbre::fe
