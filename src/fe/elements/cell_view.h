#pragma once
#include <fmt/format.h>

#include <stdexcept>

#include "fe/elements/mesh_cells.h"

namespace mimbre::fe {

/// A cell's place in the mesh.
struct CellView {
  const ElementGroup* group;  ///< null: a beam
  int index;                  ///< in the group or among the beams
  const int* nodes;
  int node_count;

  bool solid() const { return group != nullptr && !is_shell(group->type); }
  int node_dofs() const { return solid() ? 3 : 6; }
  int dofs() const { return node_count * node_dofs(); }
};

inline CellView view(const SolidMesh& mesh, const MeshCells& cells, int cell) {
  const int group = group_of(cells, cell);
  const bool beam = group == static_cast<int>(mesh.groups.size());
  return {beam ? nullptr : &mesh.groups[group], cell - cells.group_begin[group],
          cells.nodes.data() + cells.first[cell], cells.first[cell + 1] - cells.first[cell]};
}

template <class Positions>
Positions positions(const SolidMesh& mesh, const CellView& cell) {
  Positions nodes(3, cell.node_count);
  for (int k = 0; k < cell.node_count; ++k) nodes.col(k) = mesh.nodes.col(cell.nodes[k]);
  return nodes;
}

/// Names the element when `compute` finds it unsound.
template <class Compute>
void naming(const CellView& cell, const Compute& compute) {
  try {
    compute();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{}: {}", element_name(*cell.group, cell.index), error.what()));
  }
}

}  // namespace mimbre::fe
