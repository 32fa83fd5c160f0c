#include <Eigen/Core>

#include "fe/elements/cell_elements.h"
#include "fe/elements/turning_cell.h"
#include "math/once/decompositions.h"
#include "math/rotation.h"

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The rotation nearest to the nodes' displacements.
void set_turn(TurningCell& cell) {
  const Index nodes = cell.arms.cols();
  Matrix3d inertia = Matrix3d::Zero();
  cell.turn.setZero(3, cell.node_dofs * nodes);
  for (Index k = 0; k < nodes; ++k) {
    const Vector3d r = cell.arms.col(k);
    inertia += r.squaredNorm() * Matrix3d::Identity() - r * r.transpose();
    cell.turn.block<3, 3>(0, cell.node_dofs * k) = skew<double>(r);
  }
  cell.turn = inverse(inertia) * cell.turn;
}

}  // namespace

TurningCell turning_cell(const SolidMesh& mesh, const MeshCells& cells, const Mesh& beams, int number) {
  const CellView at = view(mesh, cells, number);
  if (at.group == nullptr) return turning_beam(beams, at.index);
  TurningCell cell;
  cell.node_dofs = at.node_dofs();
  cell.arms.resize(3, at.node_count);
  for (int k = 0; k < at.node_count; ++k) cell.arms.col(k) = mesh.nodes.col(at.nodes[k]);
  cell.arms.colwise() -= cell.arms.rowwise().mean().eval();
  const ElementMaterial material = material_of(mesh, at);
  if (at.solid()) {
    SolidMatrix stiffness;
    solid_stiffness(geometry_of(mesh, at), material, stiffness);
    cell.stiffness = stiffness;
  } else {
    cell.stiffness = shell_matrices(shell_of(mesh, at), material).stiffness;
  }
  set_turn(cell);
  return cell;
}

}  // namespace mimbre::fe
