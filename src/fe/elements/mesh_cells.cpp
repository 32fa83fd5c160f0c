#include "fe/elements/mesh_cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>

#include "fe/elements/solid_element.h"

namespace mimbre::fe {
namespace {

constexpr const char* kTypeNames[] = {"tet4",     "tet10",     "hex8", "hex20", "wedge6", "wedge15",
                                      "pyramid5", "pyramid13", "tri3", "quad4", "tri6",   "quad8"};

[[noreturn]] void fail(const std::string& where, const std::string& what) {
  throw std::invalid_argument(fmt::format("{}: {}", where, what));
}

std::string node_name(const SolidMesh& mesh, Eigen::Index node) {
  return fmt::format("node {}", node < static_cast<Eigen::Index>(mesh.labels.size())
                                    ? mesh.labels[static_cast<std::size_t>(node)]
                                    : node);
}

void check_nodes(const SolidMesh& mesh) {
  for (Eigen::Index node = 0; node < mesh.nodes.cols(); ++node)
    if (!mesh.nodes.col(node).allFinite()) fail(node_name(mesh, node), "its position must be finite");
}

void check_group(const SolidMesh& mesh, const ElementGroup& group) {
  if (group.nodes.empty()) return;
  const std::string where = fmt::format("element set '{}'", group.name);
  const int per_element = node_count(group.type);
  if (group.nodes.size() % per_element != 0)
    fail(where, fmt::format("{} nodes are no multiple of the {} of a {}", group.nodes.size(), per_element,
                            kTypeNames[static_cast<int>(group.type)]));
  if (group.material < 0 || group.material >= static_cast<int>(mesh.materials.size()))
    fail(element_name(group, 0), "has no material");
  try {
    const NamedMaterial& named = mesh.materials[group.material];
    if (named.elastic) check_elastic_matrix(*named.elastic);
    Material material = named.material;
    // Masses beside the elements may be all that a model has.
    if (material.density == 0 && !mesh.point_masses.empty()) material.density = 1;
    check_elastic(material);
  } catch (const std::invalid_argument& error) {
    fail(fmt::format("material '{}' of {}", mesh.materials[group.material].name, where), error.what());
  }
  const auto oriented = [&](int orientation) {
    return orientation >= 0 && orientation < static_cast<int>(mesh.orientations.size());
  };
  if (!group.orientations.empty() &&
      (static_cast<int>(group.orientations.size()) != group.size() ||
       !std::all_of(group.orientations.begin(), group.orientations.end(), oriented)))
    fail(where, fmt::format("its {} elements need as many orientations that the mesh has, {} are given",
                            group.size(), group.orientations.size()));
  if (!std::isfinite(group.offset)) fail(where, "its offset must be finite");
  if (!group.normals.empty() && group.normals.size() != group.nodes.size())
    fail(where, fmt::format("its {} nodes of elements need as many normals, {} are given", group.nodes.size(),
                            group.normals.size()));
  if (is_shell(group.type) && !(std::isfinite(group.thickness) && group.thickness > 0))
    fail(element_name(group, 0), fmt::format("its thickness must be positive, is {}", group.thickness));
}

/// Solids that fill the same place twice: both would count. (Shells may lie in layers.)
void check_no_solid_twice(const SolidMesh& mesh) {
  struct Solid {
    std::array<int, 4> lowest;  ///< of its nodes
    std::size_t group;
    int element;
  };
  std::vector<Solid> solids;
  for (std::size_t g = 0; g < mesh.groups.size(); ++g) {
    const ElementGroup& group = mesh.groups[g];
    if (is_shell(group.type)) continue;
    for (int e = 0; e < group.size(); ++e) {
      const int* const nodes = group.nodes.data() + static_cast<std::ptrdiff_t>(e) * node_count(group.type);
      Solid solid{{}, g, e};
      std::partial_sort_copy(nodes, nodes + node_count(group.type), solid.lowest.begin(), solid.lowest.end());
      solids.push_back(solid);
    }
  }
  std::sort(solids.begin(), solids.end(), [](const Solid& a, const Solid& b) {
    return std::tie(a.lowest, a.group, a.element) < std::tie(b.lowest, b.group, b.element);
  });
  const auto all_nodes = [&](const Solid& solid) {
    const ElementGroup& group = mesh.groups[solid.group];
    const int* const nodes =
        group.nodes.data() + static_cast<std::ptrdiff_t>(solid.element) * node_count(group.type);
    std::vector<int> sorted(nodes, nodes + node_count(group.type));
    std::sort(sorted.begin(), sorted.end());
    return sorted;
  };
  for (std::size_t k = 1; k < solids.size(); ++k) {
    const Solid &a = solids[k - 1], &b = solids[k];
    if (a.lowest == b.lowest && all_nodes(a) == all_nodes(b))
      fail(element_name(mesh.groups[b.group], b.element),
           fmt::format("has the same nodes as {}", element_name(mesh.groups[a.group], a.element)));
  }
}

void add_cell(MeshCells& cells, const int* nodes, int count, int dofs) {
  cells.nodes.insert(cells.nodes.end(), nodes, nodes + count);
  cells.first.push_back(static_cast<int>(cells.nodes.size()));
  for (int k = 0; k < count; ++k) {
    int& node_dofs = cells.node_dofs[nodes[k]];
    node_dofs = std::max(node_dofs, dofs);
  }
}

/// Dofs of what is not an element.
void add_dofs_beside(const SolidMesh& mesh, MeshCells& cells) {
  const auto at = [&](const std::string& what, const std::string& name, int node) -> int& {
    if (node < 0 || node >= mesh.nodes.cols())
      fail(fmt::format("{} '{}'", what, name),
           fmt::format("its node with index {} does not exist, the mesh has {}", node, mesh.nodes.cols()));
    return cells.node_dofs[static_cast<std::size_t>(node)];
  };
  // References turn; so do nodes that follow and belong to nothing else.
  for (const RigidElement& rigid : mesh.rigid_elements) {
    at("rigid element", rigid.name, rigid.reference) = 6;
    for (const int node : rigid.nodes)
      if (int& dofs = at("rigid element", rigid.name, node); dofs == 0) dofs = 6;
  }
  for (const MeanElement& mean : mesh.mean_elements) {
    at("mean element", mean.name, mean.reference) = 6;
    if (!mean.weights.empty() && mean.weights.size() != mean.nodes.size())
      fail(fmt::format("mean element '{}'", mean.name),
           fmt::format("{} weights for {} nodes", mean.weights.size(), mean.nodes.size()));
    for (const int node : mean.nodes) at("mean element", mean.name, node);
  }
  for (const PointMass& point : mesh.point_masses) {
    if (int& dofs = at("mass", point.name, point.node); dofs == 0) dofs = 3;
    if (!(std::isfinite(point.mass) && point.mass >= 0) || !point.inertia.allFinite() ||
        !point.offset.allFinite())
      fail(fmt::format("mass '{}'", point.name),
           "mass, inertia and offset must be finite, the mass not negative");
  }
  const auto terms = [&](const std::string& what, const std::string& name,
                         const std::vector<LinearTerm>& list) {
    for (const LinearTerm& term : list) {
      int& dofs = at(what, name, term.node);
      if (term.direction < 0 || term.direction > 5 || !std::isfinite(term.factor))
        fail(fmt::format("{} '{}'", what, name), "directions are 0 to 5, factors finite");
      dofs = std::max(dofs, term.direction < 3 ? 3 : 6);
    }
  };
  for (const Spring& spring : mesh.springs) terms("spring", spring.name, spring.stretch);
  for (const Equation& equation : mesh.equations) terms("equation", equation.name, equation.terms);
}

}  // namespace

std::string element_name(const ElementGroup& group, int index) {
  const auto label = index < static_cast<int>(group.labels.size()) ? group.labels[index] : index;
  return fmt::format("element {} of '{}' ({})", label, group.name, kTypeNames[static_cast<int>(group.type)]);
}

MeshCells mesh_cells(const SolidMesh& mesh) {
  check_nodes(mesh);
  std::size_t entries = 2 * mesh.beams.size();
  for (const ElementGroup& group : mesh.groups) entries += group.nodes.size();
  if (entries > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw std::length_error("the mesh has too many elements");

  const auto exists = [&](int node) { return node >= 0 && node < mesh.nodes.cols(); };
  const auto missing = [&](int node) {
    return fmt::format("its node with index {} does not exist, the mesh has {}", node, mesh.nodes.cols());
  };
  MeshCells cells;
  cells.node_dofs.assign(mesh.nodes.cols(), 0);
  cells.nodes.reserve(entries);
  cells.first.push_back(0);
  for (const ElementGroup& group : mesh.groups) {
    check_group(mesh, group);
    cells.group_begin.push_back(cells.size());
    const int per_element = node_count(group.type);
    for (int e = 0; e < group.size(); ++e) {
      const int* nodes = group.nodes.data() + static_cast<std::ptrdiff_t>(e) * per_element;
      for (int k = 0; k < per_element; ++k)
        if (!exists(nodes[k])) fail(element_name(group, e), missing(nodes[k]));
      add_cell(cells, nodes, per_element, is_shell(group.type) ? 6 : 3);
    }
  }
  cells.group_begin.push_back(cells.size());
  check_no_solid_twice(mesh);
  for (std::size_t b = 0; b < mesh.beams.size(); ++b) {
    for (int node : mesh.beams[b].nodes)
      if (!exists(node)) fail(fmt::format("beam element {}", b), missing(node));
    add_cell(cells, mesh.beams[b].nodes.data(), 2, 6);
  }
  add_dofs_beside(mesh, cells);
  return cells;
}

int group_of(const MeshCells& cells, int cell) {
  const auto above = std::upper_bound(cells.group_begin.begin(), cells.group_begin.end(), cell);
  return static_cast<int>(above - cells.group_begin.begin()) - 1;
}

}  // namespace mimbre::fe
