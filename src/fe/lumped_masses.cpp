#include "fe/lumped_masses.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

#include "fe/elements/beam_element.h"
#include "fe/elements/cell_elements.h"
#include "math/cross_matrix.h"
#include "math/once/decompositions.h"

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// The diagonal of the consistent mass, scaled to the mass of the element (Hinton, Rock, Zienkiewicz 1976);
/// then times 1 + b · (r − r̄), so that the centre of mass is the element's too, as long as all stay positive.
void lump_solid(const SolidMesh& mesh, const CellView& cell, std::vector<double>& nodal) {
  NodalMatrix consistent;
  naming(cell, [&] { solid_mass(geometry_of(mesh, cell), material_of(mesh, cell).density(), consistent); });
  const double mass = consistent.sum();
  const NodePositions nodes = positions<NodePositions>(mesh, cell);
  const Vector3d centre = nodes * consistent.rowwise().sum() / mass;
  Eigen::VectorXd lumped = mass / consistent.trace() * consistent.diagonal();
  const Vector3d mean = nodes * lumped / mass;
  const NodePositions arms = nodes.colwise() - mean;
  const Matrix3d second = arms * lumped.asDiagonal() * arms.transpose();
  const Vector3d tilt = mass * PivotedCholesky(second).solve(centre - mean);
  const Eigen::VectorXd corrected = lumped.array() * (1 + (arms.transpose() * tilt).array());
  if (corrected.minCoeff() > 0) lumped = corrected;
  for (int k = 0; k < cell.node_count; ++k) nodal[static_cast<std::size_t>(cell.nodes[k])] += lumped[k];
}

void lump_beam(const Mesh& beams, int index, std::vector<LumpedMass>& lumps) {
  const BeamElement& beam = beams.elements[static_cast<std::size_t>(index)];
  const ElementGeometry geometry = element_geometry(beams, index);
  const Vector3d axis = geometry.axes.col(0);
  const double half = 0.5 * beam.material.density * geometry.length;
  for (std::size_t end = 0; end < 2; ++end) {
    LumpedMass lump{beam.nodes[end], half * beam.section.area, beam.offsets[end]};
    lump.second = lumped_turning(beam, geometry.length) * axis * axis.transpose();
    if (has_rotary_inertia(beam))
      lump.second += half * geometry.axes * Vector3d(0, beam.section.Iz, beam.section.Iy).asDiagonal() *
                     geometry.axes.transpose();
    else
      lump.twist = 0.5 * polar_inertia(beam) * geometry.length * axis * axis.transpose();
    lumps.push_back(lump);
  }
}

Matrix6d matrix_of(const LumpedMass& lump) {
  const Matrix3d arm = cross_matrix(lump.offset);
  Matrix6d m;
  m << lump.mass * Matrix3d::Identity(), -lump.mass * arm, lump.mass * arm,
      lump.second.trace() * Matrix3d::Identity() - lump.second + lump.twist - lump.mass * arm * arm;
  return 0.5 * (m + m.transpose());
}

}  // namespace

std::vector<LumpedMass> lumped_masses(const SolidMesh& mesh) {
  const MeshCells cells = mesh_cells(mesh);
  const Mesh beams = mesh.beams.empty() ? Mesh{} : Mesh{mesh.nodes, mesh.beams};
  std::vector<double> nodal(static_cast<std::size_t>(mesh.nodes.cols()), 0.0);
  std::vector<LumpedMass> lumps;
  for (int number = 0; number < cells.size(); ++number) {
    const CellView cell = view(mesh, cells, number);
    if (cell.group == nullptr)
      lump_beam(beams, cell.index, lumps);
    else if (cell.solid())
      lump_solid(mesh, cell, nodal);
    else
      throw std::invalid_argument(fmt::format(
          "{}: masses of shells are not lumped; take the consistent mass matrix, or solids or beams",
          element_name(*cell.group, cell.index)));
  }
  for (std::size_t node = 0; node < nodal.size(); ++node)
    if (nodal[node] > 0) lumps.push_back({static_cast<int>(node), nodal[node]});
  for (const PointMass& point : mesh.point_masses)
    lumps.push_back({point.node, point.mass, point.offset,
                     0.5 * point.inertia.trace() * Matrix3d::Identity() - point.inertia});
  return lumps;
}

FeMatrices lump_masses(const SolidMesh& mesh, FeMatrices matrices) {
  if (!matrices.of_mesh)
    throw std::invalid_argument(
        "masses are lumped from the mesh's elements, but these matrices are another program's: take its "
        "lumped mass matrix, or a mesh with densities");
  std::vector<std::array<int, 6>> rows(static_cast<std::size_t>(mesh.nodes.cols()), {-1, -1, -1, -1, -1, -1});
  for (std::size_t r = 0; r < matrices.dofs.size(); ++r)
    rows[static_cast<std::size_t>(matrices.dofs[r].node)]
        [static_cast<std::size_t>(matrices.dofs[r].direction)] = static_cast<int>(r);
  std::vector<Eigen::Triplet<double>> entries;
  for (const LumpedMass& lump : lumped_masses(mesh)) {
    const Matrix6d m = matrix_of(lump);
    const auto& own = rows[static_cast<std::size_t>(lump.node)];
    for (std::size_t c = 0; c < 6; ++c)
      for (std::size_t r = 0; r < 6; ++r)
        if (own[r] >= own[c] && own[c] >= 0)
          entries.emplace_back(own[r], own[c], m(static_cast<Index>(r), static_cast<Index>(c)));
  }
  matrices.mass.setZero();
  matrices.mass.setFromTriplets(entries.begin(), entries.end());
  return matrices;
}

}  // namespace mimbre::fe
