#include <Eigen/Geometry>
#include <map>

#include "fe_files/inp/inp_model.h"

namespace mimbre::fe {
namespace {

using Eigen::Vector3d;

constexpr double in_line = 0.94;  ///< the cosine of 20°, up to which CalculiX and Abaqus take the mean

bool is_moved(const ElementGroup& group) { return is_shell(group.type) && group.offset != 0; }

Vector3d normal_of(const SolidMesh& mesh, const ElementGroup& group, int element) {
  const int* const nodes = group.nodes.data() + element * node_count(group.type);
  const auto x = [&](int k) { return Vector3d(mesh.nodes.col(nodes[k])); };
  const bool triangle = group.type == ElementType::tri3 || group.type == ElementType::tri6;
  return (triangle ? (x(1) - x(0)).cross(x(2) - x(0)) : (x(2) - x(0)).cross(x(3) - x(1))).normalized();
}

}  // namespace

void finish_inp_normals(SolidMesh& mesh) {
  const auto flat = [](const ElementGroup& group) { return node_count(group.type) <= 4; };
  std::map<int, std::vector<Vector3d>> at_nodes;
  for (const ElementGroup& group : mesh.groups)
    for (int e = 0; is_moved(group) && flat(group) && e < group.size(); ++e)
      for (int k = 0; k < node_count(group.type); ++k)
        at_nodes[group.nodes[static_cast<std::size_t>(e * node_count(group.type) + k)]].push_back(
            normal_of(mesh, group, e));
  for (ElementGroup& group : mesh.groups)
    for (int e = 0; is_moved(group) && flat(group) && e < group.size(); ++e) {
      const Vector3d own = normal_of(mesh, group, e);
      for (int k = 0; k < node_count(group.type); ++k) {
        Vector3d sum = Vector3d::Zero();
        for (const Vector3d& other :
             at_nodes.at(group.nodes[static_cast<std::size_t>(e * node_count(group.type) + k)]))
          if (other.dot(own) > in_line) sum += other;
        group.normals.push_back(sum.normalized());
      }
    }
}

}  // namespace mimbre::fe
