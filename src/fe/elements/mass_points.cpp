#include "fe/elements/mass_points.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "fe/elements/beam_element.h"
#include "fe/elements/cell_elements.h"
#include "fe/elements/congruence.h"
#include "math/cross_matrix.h"
#include "math/gauss.h"
#include "math/once/decompositions.h"

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

/// Displacement of a point by the dofs of its nodes: six per node, of solids three.
using Motion = Eigen::Matrix<double, 3, Eigen::Dynamic>;
using Visit = std::function<void(const Vector3d&, double, const Motion&)>;

void solid_points(const SolidMesh& mesh, const CellView& cell, double density, const Visit& visit) {
  const SolidGeometry geometry = geometry_of(mesh, cell);
  const auto add = [&](const ShapeSamples& samples, double share) {
    Motion motion = Motion::Zero(3, 3 * cell.node_count);
    for (const ShapeSample& sample : samples) {
      for (int a = 0; a < cell.node_count; ++a)
        motion.block<3, 3>(0, 3 * a) = sample.values[a] * Matrix3d::Identity();
      visit(geometry.nodes * sample.values, share * density * sample.weight * volume_ratio(geometry, sample),
            motion);
    }
  };
  add(mass_samples(geometry.type), geometry.reduced ? kExactShare : 1);
  if (geometry.reduced) add(stiffness_samples(geometry), 1 - kExactShare);
}

/// Four points of the section at each of four along the beam have its rotary inertia; a slender beam has them
/// on its axis.
void beam_points(const Mesh& mesh, int index, const Visit& visit) {
  const BeamElement& beam = mesh.elements[static_cast<std::size_t>(index)];
  const ElementGeometry geometry = element_geometry(mesh, index);
  const ShearRatio shear = shear_ratio(beam, geometry.length);
  const Matrix12 from_nodes = element_transformation(beam, geometry.axes);
  const double y = std::sqrt(2 * beam.section.Iz / beam.section.area),
               z = std::sqrt(2 * beam.section.Iy / beam.section.area);
  std::vector<Vector3d> arms{Vector3d::Zero()};
  if (has_rotary_inertia(beam)) arms = {{0, y, 0}, {0, -y, 0}, {0, 0, z}, {0, 0, -z}};
  for (const GaussPoint& g : gauss4) {
    const double mass = beam.material.density * beam.section.area * geometry.length * g.weight /
                        static_cast<double>(arms.size());
    const auto axis = shape_functions(g.xi, geometry.length, shear),
               turn = rotation_functions(g.xi, geometry.length, shear);
    for (const Vector3d& arm : arms)
      visit(geometry.start + geometry.axes * (Vector3d(g.xi * geometry.length, 0, 0) + arm), mass,
            geometry.axes * (axis - cross_matrix(arm) * turn) * from_nodes);
  }
}

/// Pairs of points along the principal axes; far away, with hardly any mass, where there is inertia alone.
void rigid_points(const SolidMesh& mesh, const PointMass& point, double extent, const Visit& visit) {
  const auto at = [&](const Vector3d& arm, double mass) {
    Motion motion(3, 6);
    motion << Matrix3d::Identity(), -cross_matrix(point.offset + arm);
    visit(mesh.nodes.col(point.node) + point.offset + arm, mass, motion);
  };
  // Second moments ∫ r rᵀ dm = ½ tr(J) 1 − J.
  const Matrix3d second = 0.5 * point.inertia.trace() * Matrix3d::Identity() - point.inertia;
  if (second.isZero(0)) return at(Vector3d::Zero(), point.mass);
  const double far = 1e3 * extent;
  const double mass = std::max(point.mass, 3 * second.trace() / (far * far));
  const EigenPairs pairs = symmetric_eigen(second);
  for (int k = 0; k < 3; ++k) {
    const Vector3d arm = std::sqrt(std::max(0.0, 3 * pairs.values[k] / mass)) * pairs.vectors.col(k);
    at(arm, mass / 6);
    at(-arm, mass / 6);
  }
}

double extent_of(const SolidMesh& mesh) {
  return mesh.nodes.cols() < 2 ? 1
                               : (mesh.nodes.rowwise().maxCoeff() - mesh.nodes.rowwise().minCoeff()).norm();
}

}  // namespace

bool has_rotating_mass(const SolidMesh& mesh) {
  return !mesh.beams.empty() ||
         std::any_of(mesh.groups.begin(), mesh.groups.end(),
                     [](const ElementGroup& g) { return is_shell(g.type) && !g.nodes.empty(); }) ||
         std::any_of(mesh.point_masses.begin(), mesh.point_masses.end(),
                     [](const PointMass& p) { return !p.offset.isZero(0) || !p.inertia.isZero(0); });
}

void for_each_mass_points(const SolidMesh& mesh, const std::vector<Dof>& dofs, const MatrixXd& fields,
                          const std::function<void(const MassPoints&)>& visit) {
  std::vector<std::array<Index, 6>> rows(static_cast<std::size_t>(mesh.nodes.cols()),
                                         {-1, -1, -1, -1, -1, -1});
  for (std::size_t r = 0; r < dofs.size(); ++r)
    rows[static_cast<std::size_t>(dofs[r].node)][static_cast<std::size_t>(dofs[r].direction)] =
        static_cast<Index>(r);

  constexpr Index part = 512;
  MassPoints points;
  const auto clear = [&] {
    points.places.resize(3, part);
    points.masses.resize(part);
    points.shapes.resize(3 * part, fields.cols());
  };
  clear();
  Index count = 0;
  const auto flush = [&] {
    if (count == 0) return;
    points.places.conservativeResize(3, count);
    points.masses.conservativeResize(count);
    points.shapes.conservativeResize(3 * count, fields.cols());
    visit(points);
    clear();
    count = 0;
  };
  MatrixXd local;
  const auto gather = [&](const int* nodes, int node_count, int per_node) {
    local.setZero(static_cast<Index>(node_count) * per_node, fields.cols());
    for (int k = 0; k < node_count; ++k)
      for (int d = 0; d < per_node; ++d)
        if (const Index row = rows[static_cast<std::size_t>(nodes[k])][static_cast<std::size_t>(d)]; row >= 0)
          local.row(per_node * k + d) = fields.row(row);
  };
  const auto add = [&](const Vector3d& place, double mass, const Motion& motion) {
    points.places.col(count) = place;
    points.masses[count] = mass;
    points.shapes.middleRows<3>(3 * count).noalias() = motion * local;
    if (++count == part) flush();
  };

  const MeshCells cells = mesh_cells(mesh);
  const Mesh beams = mesh.beams.empty() ? Mesh{} : Mesh{mesh.nodes, mesh.beams};
  for (int number = 0; number < cells.size(); ++number) {
    const CellView cell = view(mesh, cells, number);
    gather(cell.nodes, cell.node_count, cell.node_dofs());
    if (cell.group == nullptr) {
      beam_points(beams, cell.index, add);
      continue;
    }
    const double density = mesh.materials[static_cast<std::size_t>(cell.group->material)].material.density;
    if (cell.solid())
      solid_points(mesh, cell, density, add);
    else
      for_each_mass_point(
          shell_of(mesh, cell), density,
          [&](const Vector3d& place, double mass, const ShellField& motion) { add(place, mass, motion); });
  }
  const double extent = extent_of(mesh);
  for (const PointMass& point : mesh.point_masses) {
    gather(&point.node, 1, 6);
    rigid_points(mesh, point, extent, add);
  }
  flush();
}

std::vector<Eigen::Matrix<double, 6, 6>> point_mass_matrices(const SolidMesh& mesh) {
  const double extent = extent_of(mesh);
  std::vector<Eigen::Matrix<double, 6, 6>> matrices;
  for (const PointMass& point : mesh.point_masses) {
    Eigen::Matrix<double, 6, 6> matrix = Eigen::Matrix<double, 6, 6>::Zero();
    rigid_points(mesh, point, extent, [&](const Vector3d&, double mass, const Motion& motion) {
      add_square(matrix, mass, motion);
    });
    matrices.push_back(0.5 * (matrix + matrix.transpose()));
  }
  return matrices;
}

double element_volume(const SolidMesh& mesh) {
  const MeshCells cells = mesh_cells(mesh);
  const Mesh beams = mesh.beams.empty() ? Mesh{} : Mesh{mesh.nodes, mesh.beams};
  double volume = 0;
  for (int number = 0; number < cells.size(); ++number) {
    const CellView cell = view(mesh, cells, number);
    if (cell.group == nullptr) {
      volume += beams.elements[static_cast<std::size_t>(cell.index)].section.area *
                element_geometry(beams, cell.index).length;
    } else if (cell.solid()) {
      const SolidGeometry geometry = geometry_of(mesh, cell);
      for (const ShapeSample& sample : mass_samples(geometry.type))
        volume += sample.weight * volume_ratio(geometry, sample);
    } else {
      for_each_mass_point(shell_of(mesh, cell), 1,
                          [&](const Vector3d&, double part, const ShellField&) { volume += part; });
    }
  }
  return volume;
}

}  // namespace mimbre::fe
