#include "compile/triangle_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "math/elementary.h"

namespace mimbre {
namespace {

std::size_t at(int index) { return static_cast<std::size_t>(index); }

/// A tree of boxes by halves of the triangles along the longest side.
class TreeBuilder {
 public:
  TreeBuilder(const std::vector<Vec3d>& vertices, const std::vector<Triangle>& triangles)
      : vertices_(vertices), triangles_(triangles), order_(triangles.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    nodes_.emplace_back();
    split(0, 0, static_cast<int>(triangles.size()));
  }
  const std::vector<int>& order() const { return order_; }
  const std::vector<TriangleMesh::Node>& nodes() const { return nodes_; }

 private:
  static constexpr int fewest = 4;  ///< triangles are not split any more

  Vec3d centre(int triangle) const {
    const Triangle& t = triangles_[at(triangle)];
    return (vertices_[at(t[0])] + vertices_[at(t[1])] + vertices_[at(t[2])]) / 3;
  }

  void split(int node, int first, int last) {
    Vec3d low = vertices_[at(triangles_[at(order_[at(first)])][0])], high = low,
          least = centre(order_[at(first)]), most = least;
    for (int k = first; k < last; ++k) {
      for (const int v : triangles_[at(order_[at(k)])]) {
        low = low.cwiseMin(vertices_[at(v)]);
        high = high.cwiseMax(vertices_[at(v)]);
      }
      least = least.cwiseMin(centre(order_[at(k)]));
      most = most.cwiseMax(centre(order_[at(k)]));
    }
    nodes_[at(node)] = {low, high, first, last - first};
    if (last - first <= fewest) return;
    int axis = 0;
    (most - least).maxCoeff(&axis);
    const int middle = (first + last) / 2;
    std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                     [&](int x, int y) {
                       const double a = centre(x)[axis], b = centre(y)[axis];
                       return a != b ? a < b : x < y;
                     });
    const int children = static_cast<int>(nodes_.size());
    nodes_.resize(nodes_.size() + 2);
    nodes_[at(node)].first = children;
    nodes_[at(node)].count = 0;
    split(children, first, middle);
    split(children + 1, middle, last);
  }

  const std::vector<Vec3d>& vertices_;
  const std::vector<Triangle>& triangles_;
  std::vector<int> order_;
  std::vector<TriangleMesh::Node> nodes_;
};

}  // namespace

TriangleMesh triangle_mesh(const std::vector<Vec3d>& vertices, const std::vector<Triangle>& triangles) {
  TriangleMesh m;
  const TreeBuilder tree(vertices, triangles);
  std::vector<Triangle> sorted;
  for (const int k : tree.order()) sorted.push_back(triangles[at(k)]);
  std::vector<Vec3d> normals(vertices.size(), Vec3d::Zero());
  for (const Triangle& t : sorted)
    for (int k = 0; k < 3; ++k) {
      const Vec3d &corner = vertices[at(t[at(k)])],
                  first = (vertices[at(t[at((k + 1) % 3)])] - corner).normalized(),
                  second = (vertices[at(t[at((k + 2) % 3)])] - corner).normalized();
      const double angle = mimbre::atan2(first.cross(second).norm(), first.dot(second));
      normals[at(t[at(k)])] += angle * doubled_area(vertices, t).normalized();
    }
  const auto edges = edges_of(sorted);
  for (const Triangle& t : sorted) {
    std::array<int, 3> across{-1, -1, -1};
    for (int k = 0; k < 3; ++k)
      if (const auto other = edges.find({t[at((k + 1) % 3)], t[at(k)]}); other != edges.end())
        across[at(k)] = other->second[0];
    m.neighbours.push_back(across);
  }
  m.vertices = vertices;
  m.vertex_normals = normals;
  m.triangles = sorted;
  m.nodes = tree.nodes();
  return m;
}

TriangleMesh height_mesh(const Eigen::MatrixXd& heights, const Eigen::Vector2d& spacing) {
  const int columns = static_cast<int>(heights.cols()), rows = static_cast<int>(heights.rows());
  constexpr double far = 1e4;  // grids
  const double width = spacing[0] * (columns - 1), depth = spacing[1] * (rows - 1);
  const auto place = [&](int k, int count, double cell, double extent) {
    if (k < 0) return -far * extent;
    return k < count ? k * cell : (1 + far) * extent;
  };
  std::vector<Vec3d> vertices;
  std::vector<Triangle> triangles;
  for (int j = -1; j <= rows; ++j)
    for (int i = -1; i <= columns; ++i)
      vertices.push_back({place(i, columns, spacing[0], width), place(j, rows, spacing[1], depth),
                          heights(std::clamp(j, 0, rows - 1), std::clamp(i, 0, columns - 1))});
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) {
      const int first = j * (columns + 2) + i, above = first + columns + 2;
      triangles.push_back({first, first + 1, above + 1});
      triangles.push_back({first, above + 1, above});
    }
  return triangle_mesh(vertices, triangles);
}

}  // namespace mimbre
