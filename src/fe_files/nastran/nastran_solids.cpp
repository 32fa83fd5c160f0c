#include <fmt/format.h>

#include <Eigen/Geometry>
#include <utility>

#include "fe/elements/solid_shape.h"
#include "fe_files/nastran/nastran_build.h"

namespace mimbre::fe {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Pairs of nodes that change places when an element is numbered the other way round.
std::vector<std::pair<int, int>> mirrored(ElementType type) {
  switch (type) {
    case ElementType::tet4:
      return {{1, 2}};
    case ElementType::tet10:
      return {{1, 2}, {4, 6}, {8, 9}};
    case ElementType::hex8:
      return {{1, 3}, {5, 7}};
    case ElementType::hex20:
      return {{1, 3}, {5, 7}, {8, 11}, {9, 10}, {12, 15}, {13, 14}, {17, 19}};
    case ElementType::wedge6:
      return {{1, 2}, {4, 5}};
    case ElementType::wedge15:
      return {{1, 2}, {4, 5}, {6, 8}, {9, 11}, {13, 14}};
    case ElementType::pyramid5:
      return {{1, 3}};
    case ElementType::pyramid13:
      return {{1, 3}, {5, 8}, {6, 7}, {10, 12}};
    default:
      return {};
  }
}

/// Nastran takes both ways of numbering round the first face.
bool is_mirrored(ElementType type, const SolidMesh& mesh, const int* nodes) {
  const auto x = [&](int i) -> Vector3d { return mesh.nodes.col(nodes[i]); };
  switch (type) {
    case ElementType::tet4:
    case ElementType::tet10:
      return (x(1) - x(0)).cross(x(2) - x(0)).dot(x(3) - x(0)) < 0;
    case ElementType::wedge6:
    case ElementType::wedge15:
      return (x(1) - x(0)).cross(x(2) - x(0)).dot(x(3) + x(4) + x(5) - x(0) - x(1) - x(2)) < 0;
    case ElementType::pyramid5:
    case ElementType::pyramid13:
      return (x(2) - x(0)).cross(x(3) - x(1)).dot(4 * x(4) - x(0) - x(1) - x(2) - x(3)) < 0;
    default:
      return (x(2) - x(0)).cross(x(3) - x(1)).dot(x(4) + x(5) + x(6) + x(7) - x(0) - x(1) - x(2) - x(3)) < 0;
  }
}

struct SolidGroup {
  int index = -1;
  std::optional<std::int64_t> system;  ///< of a material with directions
  bool directed = false;
};

SolidGroup new_group(NastranBuild& build, const NastranSolid& solid) {
  const NastranModel& model = build.model;
  const auto found = model.solid_properties.find(solid.property);
  if (found == model.solid_properties.end()) {
    const auto other = model.other_properties.find(solid.property);
    throw InputError(model.mark(solid.place), other == model.other_properties.end()
                                                  ? fmt::format("property {} is not there", solid.property)
                                                  : fmt::format("property {} is a {}, which is not read",
                                                                solid.property, other->second));
  }
  const NastranSolidProperty& property = found->second;
  const NastranMaterial& material = build.material(property.material, property.place);
  if (material.kind == NastranMaterial::Kind::sheet)
    throw InputError(
        model.mark(property.place),
        fmt::format("material {} is that of a sheet; a solid needs MAT1, MAT9 or MAT11", property.material));
  SolidGroup group;
  group.directed = material.kind == NastranMaterial::Kind::solid;
  group.system = property.system;
  std::optional<ElasticMatrix> elastic;
  if (group.directed) elastic = material.elastic;
  ElementGroup made;
  made.type = solid.type;
  made.name = fmt::format("PSOLID:{}", solid.property);
  made.material =
      build.mesh_material(fmt::format("MAT:{}", property.material),
                          {material.young, material.poisson, material.density * model.mass_factor}, elastic);
  group.index = static_cast<int>(build.mesh.groups.size());
  build.mesh.groups.push_back(std::move(made));
  return group;
}

/// As Nastran has them: x from the mean of one pair of sides to the other, z across.
Matrix3d element_axes(ElementType type, const SolidMesh& mesh, const int* nodes) {
  const auto x = [&](int i) -> Vector3d { return mesh.nodes.col(nodes[i]); };
  Vector3d r, s;
  if (type == ElementType::hex8 || type == ElementType::hex20) {
    r = x(1) + x(2) + x(5) + x(6) - x(0) - x(3) - x(4) - x(7);
    s = x(2) + x(3) + x(6) + x(7) - x(0) - x(1) - x(4) - x(5);
  } else {
    r = x(1) - x(0);
    s = x(2) - x(0);
  }
  Matrix3d axes;
  axes.col(0) = r.normalized();
  axes.col(2) = r.cross(s).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

/// Node `middle` of an element whose corners are known.
int amid(NastranBuild& build, ElementType type, int middle, const std::array<int, 20>& nodes) {
  const NodePositions reference = reference_nodes(type);
  for (int a = 0; a < middle; ++a)
    for (int b = a + 1; b < middle; ++b)
      if ((reference.col(a) + reference.col(b) - 2 * reference.col(middle)).isZero(1e-12))
        return build.amid(nodes[static_cast<std::size_t>(a)], nodes[static_cast<std::size_t>(b)]);
  throw std::logic_error("a node amid no edge");
}

}  // namespace

void add_nastran_solids(NastranBuild& build) {
  NastranModel& model = build.model;
  std::map<std::pair<ElementType, std::int64_t>, SolidGroup> groups;
  for (const NastranSolid& solid : model.solids) {
    const std::string name = fmt::format("element {}", solid.label);
    build.guarded(name, solid.place, [&] {
      const int count = node_count(solid.type);
      std::array<int, 20> nodes{};
      for (int i = 0; i < count; ++i) {
        const std::int64_t label = model.element_nodes[solid.first + static_cast<std::size_t>(i)];
        nodes[static_cast<std::size_t>(i)] =
            label == 0 ? amid(build, solid.type, i, nodes) : build.node(label, solid.place, name);
        if (nodes[static_cast<std::size_t>(i)] < 0) return;
      }
      const auto [place, is_new] = groups.try_emplace({solid.type, solid.property});
      if (is_new) place->second = new_group(build, solid);
      const SolidGroup& group = place->second;
      if (group.index < 0) return;  // reported already
      if (is_mirrored(solid.type, build.mesh, nodes.data()))
        for (const auto& [a, b] : mirrored(solid.type))
          std::swap(nodes[static_cast<std::size_t>(a)], nodes[static_cast<std::size_t>(b)]);
      ElementGroup& made = build.mesh.groups[static_cast<std::size_t>(group.index)];
      made.nodes.insert(made.nodes.end(), nodes.begin(), nodes.begin() + count);
      made.labels.push_back(solid.label);
      if (!group.directed || !group.system || *group.system == 0) {
        if (!made.orientations.empty()) made.orientations.push_back(0);
        return;
      }
      Orientation orientation;
      if (*group.system > 0) {
        Vector3d centre = Vector3d::Zero();
        for (int i = 0; i < count; ++i) centre += build.at(nodes[static_cast<std::size_t>(i)]) / count;
        orientation.axes = model.systems.at(*group.system, model.mark(solid.place)).directions(centre);
      } else {
        orientation.axes = element_axes(solid.type, build.mesh, nodes.data());
      }
      made.orientations.push_back(static_cast<int>(build.mesh.orientations.size()));
      build.mesh.orientations.push_back(orientation);
    });
  }
}

}  // namespace mimbre::fe
