#pragma once
#include "fe/elements/cell_view.h"
#include "fe/elements/elastic_matrix.h"
#include "fe/elements/shell_element.h"
#include "fe/elements/solid_element.h"

/// The elements of a mesh's cells as the element functions take them.
namespace mimbre::fe {

inline ElementMaterial material_of(const SolidMesh& mesh, const CellView& cell) {
  const ElementGroup& group = *cell.group;
  const Orientation* orientation = group.orientations.empty()
                                       ? nullptr
                                       : &mesh.orientations[static_cast<std::size_t>(
                                             group.orientations[static_cast<std::size_t>(cell.index)])];
  return {mesh.materials[static_cast<std::size_t>(group.material)], orientation};
}

inline SolidGeometry geometry_of(const SolidMesh& mesh, const CellView& cell) {
  return solid_geometry(cell.group->type, positions<NodePositions>(mesh, cell),
                        cell.group->reduced_integration);
}

inline ShellGeometry shell_of(const SolidMesh& mesh, const CellView& cell) {
  const ElementGroup& group = *cell.group;
  ShellNodes normals;
  if (!group.normals.empty()) {
    normals.resize(3, cell.node_count);
    const auto first = static_cast<std::size_t>(cell.index * cell.node_count);
    for (int k = 0; k < cell.node_count; ++k)
      normals.col(k) = group.normals[first + static_cast<std::size_t>(k)];
  }
  return {group.type,   positions<ShellNodes>(mesh, cell), group.thickness,
          group.offset, group.reduced_integration,         normals};
}

}  // namespace mimbre::fe
