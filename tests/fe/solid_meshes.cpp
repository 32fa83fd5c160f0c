#include "fe/solid_meshes.h"

#include <algorithm>
#include <map>
#include <random>

namespace mimbre::test {

std::string type_name(ElementType type) {
  constexpr const char* names[] = {"tet4",     "tet10",     "hex8", "hex20", "wedge6", "wedge15",
                                   "pyramid5", "pyramid13", "tri3", "quad4", "tri6",   "quad8"};
  return names[static_cast<int>(type)];
}

ElementType corners_only(ElementType type) {
  switch (type) {
    case ElementType::tet10:
      return ElementType::tet4;
    case ElementType::hex20:
      return ElementType::hex8;
    case ElementType::wedge15:
      return ElementType::wedge6;
    case ElementType::pyramid13:
      return ElementType::pyramid5;
    default:
      return type;
  }
}

void add_edge_nodes(fe::SolidMesh& mesh, ElementType type) {
  fe::ElementGroup& group = mesh.groups[0];
  const int corners = fe::node_count(group.type);
  const int nodes = fe::node_count(type);
  const fe::NodePositions reference = fe::reference_nodes(type);
  const auto ends = [&](int middle) {
    for (int i = 0; i < corners; ++i)
      for (int j = i + 1; j < corners; ++j) {
        // Diagonals of faces and of the volume have no node in the middle of the tests' types.
        const Eigen::Vector3d d = reference.col(j) - reference.col(i);
        const bool edge = corners == 8   ? d.norm() < 2.1
                          : corners == 5 ? d.z() != 0 || d.norm() < 2.1
                                         : corners == 4 || d.z() == 0 || d.head<2>().norm() == 0;
        if (edge && (reference.col(i) + reference.col(j) - 2 * reference.col(middle)).norm() < 1e-12)
          return std::array{i, j};
      }
    return std::array{-1, -1};
  };
  std::map<std::array<int, 2>, int> middles;
  std::vector<Eigen::Vector3d> added;
  std::vector<int> connectivity;
  for (int e = 0; e < group.size(); ++e) {
    const int* corner = group.nodes.data() + e * corners;
    for (int k = 0; k < corners; ++k) connectivity.push_back(corner[k]);
    for (int k = corners; k < nodes; ++k) {
      const auto [i, j] = ends(k);
      std::array<int, 2> key{std::min(corner[i], corner[j]), std::max(corner[i], corner[j])};
      const auto [it, is_new] = middles.try_emplace(key, static_cast<int>(mesh.nodes.cols() + added.size()));
      if (is_new) added.push_back(0.5 * (mesh.nodes.col(key[0]) + mesh.nodes.col(key[1])));
      connectivity.push_back(it->second);
    }
  }
  const Eigen::Index before = mesh.nodes.cols();
  mesh.nodes.conservativeResize(3, before + static_cast<Eigen::Index>(added.size()));
  for (std::size_t k = 0; k < added.size(); ++k)
    mesh.nodes.col(before + static_cast<Eigen::Index>(k)) = added[k];
  group.type = type;
  group.nodes = connectivity;
}

fe::SolidMesh block(ElementType type, const Eigen::Vector3d& size, const std::array<int, 3>& counts,
                    const fe::Material& material, const Place& place) {
  const auto [nx, ny, nz] = counts;
  fe::SolidMesh mesh;
  mesh.nodes.resize(3, (nx + 1) * (ny + 1) * (nz + 1));
  const auto node = [&](int i, int j, int k) { return i + (nx + 1) * (j + (ny + 1) * k); };
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i) {
        const Eigen::Vector3d at(size.x() * i / nx, size.y() * j / ny, size.z() * k / nz);
        mesh.nodes.col(node(i, j, k)) = place ? place(at) : at;
      }
  mesh.materials = {{"material", material}};
  mesh.groups.resize(1);
  fe::ElementGroup& group = mesh.groups[0];
  group.name = "block";
  group.material = 0;
  group.type = corners_only(type);
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        const std::array<int, 8> c{
            node(i, j, k),     node(i + 1, j, k),     node(i + 1, j + 1, k),     node(i, j + 1, k),
            node(i, j, k + 1), node(i + 1, j, k + 1), node(i + 1, j + 1, k + 1), node(i, j + 1, k + 1)};
        const auto add = [&](std::initializer_list<int> corners) {
          for (int corner : corners) group.nodes.push_back(c[corner]);
        };
        if (group.type == ElementType::hex8) {
          add({0, 1, 2, 3, 4, 5, 6, 7});
        } else if (group.type == ElementType::wedge6) {
          add({0, 1, 2, 4, 5, 6});
          add({0, 2, 3, 4, 6, 7});
        } else if (group.type == ElementType::pyramid5) {
          const auto centre = static_cast<int>(mesh.nodes.cols());
          Eigen::Vector3d middle = Eigen::Vector3d::Zero();
          for (const int corner : c) middle += mesh.nodes.col(corner) / 8;
          mesh.nodes.conservativeResize(3, centre + 1);
          mesh.nodes.col(centre) = middle;
          for (const auto& face : {std::array{0, 1, 2, 3}, std::array{4, 7, 6, 5}, std::array{0, 4, 5, 1},
                                   std::array{1, 5, 6, 2}, std::array{2, 6, 7, 3}, std::array{3, 7, 4, 0}}) {
            for (const int corner : face) group.nodes.push_back(c[corner]);
            group.nodes.push_back(centre);
          }
        } else {  // six round the diagonal 0–6
          add({0, 1, 2, 6});
          add({0, 2, 3, 6});
          add({0, 3, 7, 6});
          add({0, 7, 4, 6});
          add({0, 4, 5, 6});
          add({0, 5, 1, 6});
        }
      }
  if (type != group.type) add_edge_nodes(mesh, type);
  return mesh;
}

fe::SolidMesh shell_mesh(ElementType type, int nx, int ny, const fe::Material& material, double thickness,
                         const std::function<Eigen::Vector3d(double, double)>& place) {
  fe::SolidMesh mesh;
  mesh.nodes.resize(3, (nx + 1) * (ny + 1));
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i)
      mesh.nodes.col(i + (nx + 1) * j) = place(static_cast<double>(i) / nx, static_cast<double>(j) / ny);
  mesh.materials = {{"material", material}};
  fe::ElementGroup group{type, "shell", 0, thickness, {}, {}};
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      const int a = i + (nx + 1) * j;
      if (type == ElementType::quad4)
        group.nodes.insert(group.nodes.end(), {a, a + 1, a + nx + 2, a + nx + 1});
      else
        group.nodes.insert(group.nodes.end(), {a, a + 1, a + nx + 2, a, a + nx + 2, a + nx + 1});
    }
  mesh.groups.push_back(group);
  return mesh;
}

fe::NodePositions single_element(ElementType type, double distortion, unsigned seed) {
  std::mt19937 generator(seed);
  const auto random = [&] { return generator() / 2147483648.0 - 1.0; };
  Eigen::Matrix3d A;
  A << 1.2, 0.2, -0.1, 0.15, 0.8, 0.1, -0.05, 0.1, 0.9;
  fe::NodePositions nodes = A * fe::reference_nodes(type);
  nodes.colwise() += Eigen::Vector3d(0.3, -0.2, 0.5);
  for (double& x : nodes.reshaped()) x += distortion * random();
  return nodes;
}

Eigen::MatrixXd rigid_motions(const Eigen::Matrix3Xd& nodes) {
  Eigen::MatrixXd motions(3 * nodes.cols(), 6);
  for (Eigen::Index n = 0; n < nodes.cols(); ++n) {
    motions.block<3, 3>(3 * n, 0).setIdentity();
    for (int k = 0; k < 3; ++k)
      motions.block<3, 1>(3 * n, 3 + k) = Eigen::Vector3d::Unit(k).cross(nodes.col(n));
  }
  return motions;
}

}  // namespace mimbre::test
