#include "fe_files/element_faces.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <span>

namespace mimbre::fe {

namespace {

// Abaqus Analysis User's Guide, "Solid elements": faces by corners and edges by corners, in the order of the
// nodes amid the edges.
using Face = std::array<int, 4>;  // -1: triangle
using Edge = std::array<int, 2>;

constexpr Face tet_faces[] = {{0, 1, 2, -1}, {0, 3, 1, -1}, {1, 3, 2, -1}, {2, 3, 0, -1}};
constexpr Edge tet_edges[] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
constexpr Face hex_faces[] = {{0, 1, 2, 3}, {4, 7, 6, 5}, {0, 4, 5, 1},
                              {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}};
constexpr Edge hex_edges[] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                              {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
constexpr Face wedge_faces[] = {{0, 1, 2, -1}, {3, 5, 4, -1}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}};
constexpr Edge wedge_edges[] = {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}};

// As C3D5 has them.
constexpr Face pyramid_faces[] = {{0, 1, 2, 3}, {0, 4, 1, -1}, {1, 4, 2, -1}, {2, 4, 3, -1}, {3, 4, 0, -1}};
constexpr Edge pyramid_edges[] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}};

}  // namespace

std::vector<int> face_nodes(ElementType type, int face) {
  std::span<const Face> faces;
  std::span<const Edge> edges;
  switch (type) {
    case ElementType::tri3:
    case ElementType::quad4:
    case ElementType::tri6:
    case ElementType::quad8: {
      if (face != 1 && face != 2) return {};
      std::vector<int> all(static_cast<std::size_t>(node_count(type)));
      std::iota(all.begin(), all.end(), 0);
      return all;
    }
    case ElementType::tet10:
      edges = tet_edges;
      [[fallthrough]];
    case ElementType::tet4:
      faces = tet_faces;
      break;
    case ElementType::hex20:
      edges = hex_edges;
      [[fallthrough]];
    case ElementType::hex8:
      faces = hex_faces;
      break;
    case ElementType::wedge15:
      edges = wedge_edges;
      [[fallthrough]];
    case ElementType::wedge6:
      faces = wedge_faces;
      break;
    case ElementType::pyramid13:
      edges = pyramid_edges;
      [[fallthrough]];
    case ElementType::pyramid5:
      faces = pyramid_faces;
      break;
  }
  if (face < 1 || face > static_cast<int>(faces.size())) return {};
  std::vector<int> nodes;
  for (const int corner : faces[static_cast<std::size_t>(face - 1)])
    if (corner >= 0) nodes.push_back(corner);
  const std::vector<int> corners = nodes;
  const int first_mid = node_count(type) - static_cast<int>(edges.size());
  // Amid the sides in the order of the corners, as shape functions of the face have them.
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const int from = corners[k], to = corners[(k + 1) % corners.size()];
    for (std::size_t e = 0; e < edges.size(); ++e)
      if (edges[e] == Edge{from, to} || edges[e] == Edge{to, from})
        nodes.push_back(first_mid + static_cast<int>(e));
  }
  return nodes;
}

}  // namespace mimbre::fe
