#include "reduction/connected_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "fe/node_label.h"

namespace mimbre::fe {
namespace {

/// Disjoint sets of nodes.
class Parts {
 public:
  explicit Parts(Eigen::Index nodes) : parent_(static_cast<std::size_t>(nodes)) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int of(int node) {
    while (parent_[static_cast<std::size_t>(node)] != node) {
      int& up = parent_[static_cast<std::size_t>(node)];
      up = parent_[static_cast<std::size_t>(up)];
      node = up;
    }
    return node;
  }
  void join(int a, int b) {
    const int one = of(a), other = of(b);
    parent_[static_cast<std::size_t>(std::max(one, other))] = std::min(one, other);
  }

 private:
  std::vector<int> parent_;
};

/// Nodes that lie where one of another part does, to a millionth of the model.
int coincident(const SolidMesh& mesh, const std::vector<int>& nodes, Parts& parts) {
  const Eigen::Vector3d low = mesh.nodes.rowwise().minCoeff();
  const double size = (mesh.nodes.colwise() - low).maxCoeff();
  const double cell = std::max(1e-6 * size, 1e-300);
  std::map<std::array<long long, 3>, int> part_at;
  int count = 0;
  for (const int node : nodes) {
    std::array<long long, 3> place{};
    for (int k = 0; k < 3; ++k)
      place[static_cast<std::size_t>(k)] = std::llround((mesh.nodes(k, node) - low[k]) / cell);
    const auto [found, fresh] = part_at.try_emplace(place, parts.of(node));
    if (!fresh && found->second != parts.of(node)) ++count;
  }
  return count;
}

}  // namespace

Check connected_check(const SolidMesh& mesh, const FeMatrices& matrices,
                      const std::vector<Interface>& interfaces) {
  Parts parts(mesh.nodes.cols());
  const auto node_of = [&](Eigen::Index row) { return matrices.dofs[static_cast<std::size_t>(row)].node; };
  for (Eigen::Index c = 0; c < matrices.stiffness.cols(); ++c)
    for (Eigen::SparseMatrix<double>::InnerIterator it(matrices.stiffness, c); it; ++it)
      if (node_of(it.row()) != node_of(c)) parts.join(node_of(it.row()), node_of(c));
  const auto exists = [&](int node) { return node >= 0 && node < mesh.nodes.cols(); };
  for (const Interface& interface : interfaces)
    for (const int node : interface.nodes)
      if (exists(node) && exists(interface.nodes.front())) parts.join(node, interface.nodes.front());

  std::vector<int> nodes;
  std::map<int, int> sizes;  // of the parts, by their first node
  for (const Dof& dof : matrices.dofs)
    if (nodes.empty() || nodes.back() != dof.node) {
      nodes.push_back(dof.node);
      ++sizes[parts.of(dof.node)];
    }
  if (sizes.size() <= 1) return {"connected", true, "elements and interfaces join all nodes"};
  const auto smallest = std::min_element(sizes.begin(), sizes.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
  const Eigen::Vector3d place = mesh.nodes.col(smallest->first);
  const int same = coincident(mesh, nodes, parts);
  return {"connected", false,
          fmt::format(
              "the model is in {} parts that no element joins; the smallest has {} node{}, one of them "
              "{} at ({:.4g}, {:.4g}, {:.4g}) m{}",
              sizes.size(), smallest->second, smallest->second == 1 ? "" : "s",
              label_of(mesh, smallest->first), place.x(), place.y(), place.z(),
              same > 0 ? fmt::format("; {} nodes of different parts coincide: merge them in the mesh", same)
                       : "")};
}

}  // namespace mimbre::fe
