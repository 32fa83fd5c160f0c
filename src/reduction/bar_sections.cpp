#include "reduction/bar_sections.h"

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "fe/solve/symmetric_solver.h"
#include "reduction/inertia_fields.h"
#include "reduction/stiffening/geometric_stiffness.h"

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

/// Unit columns of the dofs that are not held.
Eigen::SparseMatrix<double> free_dofs(const Mesh& mesh, const ReductionOptions& options) {
  std::vector<bool> held(static_cast<std::size_t>(6 * mesh.nodes.cols()), false);
  for (const int node : options.clamped_nodes)
    for (int k = 0; k < 6; ++k) held[static_cast<std::size_t>(6 * node + k)] = true;
  for (const int dof : options.fixed_dofs) held[static_cast<std::size_t>(dof)] = true;
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t dof = 0; dof < held.size(); ++dof)
    if (!held[dof]) entries.emplace_back(static_cast<int>(dof), static_cast<int>(entries.size()), 1.0);
  Eigen::SparseMatrix<double> columns(6 * mesh.nodes.cols(), static_cast<Index>(entries.size()));
  columns.setFromTriplets(entries.begin(), entries.end());
  return columns;
}

/// 2 e × shapes: translations and rotations of each node.
MatrixXd coriolis(const Vector3d& axis, const MatrixXd& shapes) {
  MatrixXd field(shapes.rows(), shapes.cols());
  for (Index column = 0; column < shapes.cols(); ++column)
    for (Index at = 0; at < shapes.rows(); at += 3)
      field.col(column).segment<3>(at) = 2 * axis.cross(Vector3d(shapes.col(column).segment<3>(at)));
  return field;
}

/// Twelve values of a beam's nodes, one column for each load.
MatrixXd nodal_rows(const BeamElement& beam, const MatrixXd& all) {
  MatrixXd rows(12, all.cols());
  for (int end = 0; end < 2; ++end) rows.middleRows<6>(6 * end) = all.middleRows<6>(6 * beam.nodes[end]);
  return rows;
}

/// Where an element lies in its bar.
struct InBar {
  int element = 1;    ///< from 1
  double before = 0;  ///< m of the bar
};

BarSections::Section section_at(const ElementGeometry& geometry, const BeamElement& beam, const InBar& place,
                                bool end) {
  const Section& section = beam.section;
  BarSections::Section out;
  out.bar = beam.bar;
  out.element = place.element;
  out.along = place.before + (end ? geometry.length : 0.0);
  out.position = geometry.start + (end ? geometry.length : 0.0) * geometry.axes.col(0);
  out.axes = geometry.axes;
  out.area = section.area;
  out.Iy = section.Iy;
  out.Iz = section.Iz;
  out.reach_y = section.reach_y;
  out.reach_z = section.reach_z;
  out.torsion_modulus = section.torsion_modulus;
  out.round = section.round;
  return out;
}

}  // namespace

BarSections bar_sections(const Mesh& mesh, const Matrices& matrices, const ReductionOptions& options,
                         const std::vector<NodeFrame>& frames, const MatrixXd& shapes) {
  constexpr Index inertial = GeometricStiffness::boundary;
  const Index modes = shapes.cols(), of_frames = inertial + 4 * modes;
  // Of the modes' motions the accelerations at the nodes.
  MatrixXd moving(shapes.rows(), 4 * modes);
  moving.leftCols(modes) = shapes;
  for (int axis = 0; axis < 3; ++axis)
    moving.middleCols((1 + axis) * modes, modes) = coriolis(Vector3d::Unit(axis), shapes);

  MatrixXd forces = MatrixXd::Zero(shapes.rows(), of_frames + 6 * static_cast<Index>(frames.size()));
  forces.leftCols(inertial) = unit_inertia_forces(mesh, options.mass_matrix);
  forces.middleCols(inertial, 4 * modes) = -(matrices.mass * moving);
  for (std::size_t f = 0; f < frames.size(); ++f)
    for (int k = 0; k < 6; ++k) forces(6 * frames[f].node + k, of_frames + 6 * static_cast<Index>(f) + k) = 1;

  const Eigen::SparseMatrix<double> free = free_dofs(mesh, options);
  const Eigen::SparseMatrix<double> stiffness = free.transpose() * matrices.stiffness * free;
  const SymmetricSolver factor(stiffness);
  if (!factor.ok()) throw std::invalid_argument("the stiffness of the clamped body is singular");
  const MatrixXd displacements = free * factor.solve(free.transpose() * forces);

  BarSections out;
  const int elements = static_cast<int>(mesh.elements.size());
  out.influence.resize(12 * elements, forces.cols());
  const auto fields = unit_fields();
  InBar place;
  for (int e = 0; e < elements; ++e) {
    const BeamElement& beam = mesh.elements[static_cast<std::size_t>(e)];
    const ElementGeometry geometry = element_geometry(mesh, e);
    const Matrix12 transformation = element_transformation(beam, geometry.axes);
    MatrixXd ends =
        element_stiffness(beam, geometry.length) * transformation * nodal_rows(beam, displacements);
    const Matrix12 thin = thin_mass(beam, geometry.length, options.mass_matrix);
    for (Index l = 0; l < inertial; ++l)
      ends.col(l) += thin * element_field(geometry, fields[static_cast<std::size_t>(l)]);
    ends.middleCols(inertial, 4 * modes) +=
        element_mass(beam, geometry.length, options.mass_matrix) * transformation * nodal_rows(beam, moving);
    // What the rest of the body does to the element's start is minus what acts on the part before it.
    out.influence.middleRows<6>(12 * e) = -ends.topRows<6>();
    out.influence.middleRows<6>(12 * e + 6) = ends.bottomRows<6>();
    if (e > 0 && mesh.elements[static_cast<std::size_t>(e - 1)].bar != beam.bar) place = {};
    for (const bool end : {false, true}) out.sections.push_back(section_at(geometry, beam, place, end));
    place = {place.element + 1, place.before + geometry.length};
  }
  return out;
}

std::optional<BarStress> bar_stress(const Mesh& mesh, const MatrixXd& shapes) {
  BarStress out;
  out.shapes.resize(8 * static_cast<Index>(mesh.elements.size()), shapes.cols());
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const BeamElement& beam = mesh.elements[static_cast<std::size_t>(e)];
    const Section& s = beam.section;
    if (!(s.reach_y > 0 && s.reach_z > 0 && s.torsion_modulus > 0)) return std::nullopt;
    const ElementGeometry geometry = element_geometry(mesh, e);
    MatrixXd forces = element_stiffness(beam, geometry.length) * element_transformation(beam, geometry.axes) *
                      nodal_rows(beam, shapes);
    forces.topRows<6>() *= -1;  // on the part before the section
    for (int end = 0; end < 2; ++end) {
      auto stress = out.shapes.middleRows<4>(8 * e + 4 * end);
      stress.row(0) = forces.row(6 * end) / s.area;
      stress.row(1) = forces.row(6 * end + 4) * s.reach_z / s.Iy;
      stress.row(2) = forces.row(6 * end + 5) * s.reach_y / s.Iz;
      stress.row(3) = forces.row(6 * end + 3) * std::sqrt(3.0) / s.torsion_modulus;
    }
    out.round.push_back(s.round);
  }
  return out;
}

}  // namespace mimbre::fe
