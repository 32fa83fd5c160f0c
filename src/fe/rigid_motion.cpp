#include "fe/rigid_motion.h"
#include "math/once/decompositions.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <vector>

namespace mimbre::fe {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// For every node the lowest-numbered node of its connected part.
std::vector<int> connected_parts(const Mesh& mesh) {
  std::vector<int> parent(mesh.nodes.cols());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int node) {
    while (parent[node] != node) node = parent[node] = parent[parent[node]];
    return node;
  };
  for (const BeamElement& element : mesh.elements) {
    const int a = root(element.nodes[0]);
    const int b = root(element.nodes[1]);
    parent[std::max(a, b)] = std::min(a, b);
  }
  for (int node = 0; node < static_cast<int>(parent.size()); ++node) parent[node] = root(node);
  return parent;
}

}  // namespace

RigidMotions free_rigid_motions(const Mesh& mesh, const Eigen::SparseMatrix<double>& fixed) {
  if (mesh.nodes.cols() == 0) return {};
  const std::vector<int> part = connected_parts(mesh);
  const Eigen::Vector3d centre = mesh.nodes.rowwise().mean();
  const double extent = (mesh.nodes.colwise() - centre).colwise().norm().maxCoeff();
  const double size = extent > 0 ? extent : 1;

  // A rigid motion (t, φ) moves a held direction (d of translation, e of rotation) at r by d·(t + φ × r) +
  // e·φ. Rotations are counted times the mesh's size, so that all six have the unit of length.
  std::vector<Matrix6> held(mesh.nodes.cols(), Matrix6::Zero());
  for (Eigen::Index column = 0; column < fixed.outerSize(); ++column) {
    Vector6 direction = Vector6::Zero();
    int node = 0;
    for (Eigen::SparseMatrix<double>::InnerIterator it(fixed, column); it; ++it) {
      node = static_cast<int>(it.row()) / 6;
      direction[it.row() % 6] = it.value();
    }
    const Eigen::Vector3d arm = (mesh.nodes.col(node) - centre) / size;
    Vector6 row = direction;
    row.tail<3>() += arm.cross(direction.head<3>());
    held[part[node]] += row * row.transpose();
  }

  RigidMotions motions;
  for (int node = 0; node < mesh.nodes.cols(); ++node) {
    if (part[node] != node) continue;
    const Vector6 values = eigenvalues6(held[node]);
    const int rank = static_cast<int>((values.array() > 1e-12).count());
    if (rank < 6 && motions.node < 0) motions.node = node;
    motions.count += 6 - rank;
  }
  return motions;
}

}  // namespace mimbre::fe
