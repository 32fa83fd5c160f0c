#include <fmt/format.h>

#include <stdexcept>

#include "fe/elements/beam_element.h"
#include "fe/elements/cell_elements.h"
#include "fe/elements/cell_loop.h"
#include "fe/elements/mass_points.h"
#include "fe/elements/shell_element.h"
#include "fe/elements/solid_element.h"
#include "fe/elements/solid_stress.h"
#include "fe/solve/block_pattern.h"
#include "mimbre/fe_mesh.h"

namespace mimbre::fe {
namespace {

using DenseMap = Eigen::Map<Eigen::MatrixXd>;
using ConstDenseMap = Eigen::Map<const Eigen::MatrixXd>;

bool only_solids(const SolidMesh& mesh) {
  bool only = mesh.beams.empty();
  for (const ElementGroup& group : mesh.groups) only = only && (!is_shell(group.type) || group.nodes.empty());
  return only;
}

/// Calls visit(place, a, b) for the pairs of the cell's nodes whose block lies in the lower triangle: columns
/// of local node a, rows of local node b.
template <class Owned, class Visit>
void for_each_block(const BlockPattern& pattern, const CellView& cell, const Owned& owned,
                    const Visit& visit) {
  for (int a = 0; a < cell.node_count; ++a) {
    if (!owned(cell.nodes[a])) continue;
    for (int b = 0; b < cell.node_count; ++b)
      if (cell.nodes[b] >= cell.nodes[a]) visit(neighbour_place(pattern, cell.nodes[a], cell.nodes[b]), a, b);
  }
}

void add_block(Eigen::SparseMatrix<double>& matrix, const BlockPattern& pattern, const CellView& cell,
               const ConstDenseMap& values, int place, int a, int b) {
  const int dofs = cell.node_dofs();
  add_full_block(matrix, pattern, cell.nodes[a], place, dofs,
                 [&](int row, int column) { return values(dofs * b + row, dofs * a + column); });
}

std::vector<Dof> dofs_of(const MeshCells& cells) {
  std::vector<Dof> dofs;
  for (int node = 0; node < static_cast<int>(cells.node_dofs.size()); ++node)
    for (int direction = 0; direction < cells.node_dofs[node]; ++direction) dofs.push_back({node, direction});
  return dofs;
}

int used_threads(int threads) { return threads > 0 ? threads : hardware_threads(); }

/// The element functions for beams take a mesh of beams.
Mesh beam_mesh(const SolidMesh& mesh) {
  if (mesh.beams.empty()) return {};
  return {mesh.nodes, mesh.beams};
}

/// Adds the point masses and the springs.
void add_points_and_springs(const SolidMesh& mesh, const BlockPattern& pattern, FeMatrices& matrices) {
  using Entries = std::vector<Eigen::Triplet<double>>;
  const auto add_to = [](Eigen::SparseMatrix<double>& matrix, const Entries& entries) {
    Eigen::SparseMatrix<double> more(matrix.rows(), matrix.cols());
    more.setFromTriplets(entries.begin(), entries.end());
    matrix = Eigen::SparseMatrix<double>(matrix + more);
  };
  if (!mesh.point_masses.empty()) {
    Entries entries;
    const auto blocks = point_mass_matrices(mesh);
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      const int node = mesh.point_masses[k].node;
      const int first = pattern.first_dof[node], dofs = pattern.first_dof[node + 1] - first;
      for (int c = 0; c < dofs; ++c)
        for (int r = c; r < dofs; ++r) entries.emplace_back(first + r, first + c, blocks[k](r, c));
    }
    add_to(matrices.mass, entries);
  }
  if (mesh.springs.empty()) return;
  Entries entries;
  for (const Spring& spring : mesh.springs)
    for (const LinearTerm& a : spring.stretch)
      for (const LinearTerm& b : spring.stretch) {
        const int row = pattern.first_dof[a.node] + a.direction,
                  column = pattern.first_dof[b.node] + b.direction;
        if (row >= column) entries.emplace_back(row, column, spring.stiffness * a.factor * b.factor);
      }
  add_to(matrices.stiffness, entries);
}

}  // namespace

FeMatrices assemble(const SolidMesh& mesh, int threads) {
  const MeshCells cells = mesh_cells(mesh);
  const BlockPattern pattern = block_pattern(cells);
  const Mesh beams = beam_mesh(mesh);
  const BlockKind mass_kind = only_solids(mesh) ? BlockKind::diagonal : BlockKind::full;
  FeMatrices result{empty_matrix(pattern, mass_kind), empty_matrix(pattern, BlockKind::full), dofs_of(cells)};

  // Stiffness, then mass; of a solid the mass of node pairs only.
  const auto mass_size = [](const CellView& cell) { return cell.solid() ? cell.node_count : cell.dofs(); };
  const auto size = [&](int number) {
    const CellView cell = view(mesh, cells, number);
    return cell.dofs() * cell.dofs() + mass_size(cell) * mass_size(cell);
  };
  const auto compute = [&](int number, double* values) {
    const CellView cell = view(mesh, cells, number);
    DenseMap stiffness(values, cell.dofs(), cell.dofs());
    DenseMap mass(values + stiffness.size(), mass_size(cell), mass_size(cell));
    if (cell.group == nullptr) {
      const BeamElement& beam = mesh.beams[cell.index];
      const ElementGeometry geometry = element_geometry(beams, cell.index);
      const Matrix12 transformation = element_transformation(beam, geometry.axes);
      stiffness = transformation.transpose() * element_stiffness(beam, geometry.length) * transformation;
      mass = transformation.transpose() * element_mass(beam, geometry.length) * transformation;
      return;
    }
    naming(cell, [&] {
      const ElementMaterial material = material_of(mesh, cell);
      if (cell.solid()) {
        const SolidGeometry geometry = geometry_of(mesh, cell);
        SolidMatrix K;
        NodalMatrix M;
        solid_stiffness(geometry, material, K);
        solid_mass(geometry, material.density(), M);
        stiffness = K;
        mass = M;
      } else {
        const ShellMatrices shell = shell_matrices(shell_of(mesh, cell), material);
        stiffness = shell.stiffness;
        mass = shell.mass;
      }
    });
  };
  const auto add = [&](int number, const double* values, const auto& owned) {
    const CellView cell = view(mesh, cells, number);
    const ConstDenseMap stiffness(values, cell.dofs(), cell.dofs());
    const ConstDenseMap mass(values + stiffness.size(), mass_size(cell), mass_size(cell));
    for_each_block(pattern, cell, owned, [&](int place, int a, int b) {
      add_block(result.stiffness, pattern, cell, stiffness, place, a, b);
      if (cell.solid())
        add_scalar_block(result.mass, pattern, mass_kind, cell.nodes[a], place, mass(b, a));
      else
        add_block(result.mass, pattern, cell, mass, place, a, b);
    });
  };
  loop_over_cells(cells, used_threads(threads), size, compute, add);
  add_points_and_springs(mesh, pattern, result);
  result.of_mesh = true;
  return result;
}

namespace {

NodePositions cell_displacements(const BlockPattern& pattern, const CellView& cell,
                                 const Eigen::Ref<const Eigen::VectorXd>& displacements) {
  NodePositions u(3, cell.node_count);
  for (int k = 0; k < cell.node_count; ++k)
    u.col(k) = displacements.segment<3>(pattern.first_dof[cell.nodes[k]]);
  return u;
}

void check_displacements(const BlockPattern& pattern, Eigen::Index size) {
  if (size != pattern.first_dof.back())
    throw std::invalid_argument(
        fmt::format("{} displacements given, the mesh has {} dofs", size, pattern.first_dof.back()));
}

}  // namespace

Eigen::SparseMatrix<double> geometric_stiffness(const SolidMesh& mesh,
                                                const Eigen::Ref<const Eigen::VectorXd>& displacements,
                                                int threads) {
  if (!only_solids(mesh))
    throw std::invalid_argument("the geometric stiffness of a mesh with shells or beams is not available");
  const MeshCells cells = mesh_cells(mesh);
  const BlockPattern pattern = block_pattern(cells);
  check_displacements(pattern, displacements.size());
  Eigen::SparseMatrix<double> result = empty_matrix(pattern, BlockKind::diagonal);

  const auto size = [&](int number) {
    const int nodes = view(mesh, cells, number).node_count;
    return nodes * nodes;
  };
  const auto compute = [&](int number, double* values) {
    const CellView cell = view(mesh, cells, number);
    naming(cell, [&] {
      NodalMatrix K;
      solid_geometric_stiffness(geometry_of(mesh, cell), material_of(mesh, cell),
                                cell_displacements(pattern, cell, displacements), K);
      DenseMap(values, cell.node_count, cell.node_count) = K;
    });
  };
  const auto add = [&](int number, const double* values, const auto& owned) {
    const CellView cell = view(mesh, cells, number);
    const ConstDenseMap K(values, cell.node_count, cell.node_count);
    for_each_block(pattern, cell, owned, [&](int place, int a, int b) {
      add_scalar_block(result, pattern, BlockKind::diagonal, cell.nodes[a], place, K(b, a));
    });
  };
  loop_over_cells(cells, used_threads(threads), size, compute, add);
  return result;
}

}  // namespace mimbre::fe
