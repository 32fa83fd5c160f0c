#pragma once
#include <string>
#include <vector>

#include "mimbre/fe_mesh.h"

/// All elements of a mesh in one list ("cells"): those of the groups in their order, then the beams.
namespace mimbre::fe {

struct MeshCells {
  std::vector<int> first;        ///< of each cell's nodes in `nodes`, and the end
  std::vector<int> nodes;        ///< indices into the mesh's nodes
  std::vector<int> group_begin;  ///< first cell of each group; last: the first beam
  std::vector<int> node_dofs;    ///< 0 (no element), 3 or 6 (shells, beams) of each node

  int size() const { return static_cast<int>(first.size()) - 1; }
};

/// Throws std::invalid_argument that names the element or node for nodes that do not exist, positions that
/// are not finite, missing or unsound materials and thicknesses.
MeshCells mesh_cells(const SolidMesh& mesh);

/// Group of a cell, or the number of groups for a beam.
int group_of(const MeshCells& cells, int cell);

/// For messages, as "element 12 of 'arm' (tet10)".
std::string element_name(const ElementGroup& group, int index);

}  // namespace mimbre::fe
