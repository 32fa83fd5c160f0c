#include "reduction/stiffening/geometric_stiffness.h"

#include <Eigen/Core>
#include <stdexcept>

#include "fe/elements/beam_element.h"
#include "math/once/decompositions.h"
#include "reduction/inertia_fields.h"

namespace mimbre::fe {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// A prestress below this part of what its load could cause at most is round-off.
constexpr double negligible_stiffness = 1e-7;

Vector12 nodal_values(const BeamElement& beam, const VectorXd& displacement) {
  Vector12 values;
  for (int end = 0; end < 2; ++end) values.segment<6>(6 * end) = displacement.segment<6>(6 * beam.nodes[end]);
  return values;
}

/// start + factor ∫ p dξ of a p of the second degree.
SectionForces::Polynomial integrated(double start, double factor, const SectionForces::Polynomial& p) {
  return {start, factor * p[0], factor * p[1] / 2, factor * p[2] / 3};
}

/// Of a beam by its displacements and an acceleration field: at its start those of its ends, which consistent
/// forces make exact; along it as the inertia forces of the field, −ρA times its value, and M' = −x × F
/// change them. Masses lumped at the ends are outside, and leave the forces along it constant.
SectionForces section_forces(const BeamElement& beam, double length, const Vector12& dofs,
                             const Vector12& field, MassMatrix mass_matrix) {
  const bool lumped = mass_matrix == MassMatrix::lumped;
  Vector12 ends;
  if (lumped)
    ends = element_stiffness(beam, length) * dofs;
  else
    ends = element_stiffness(beam, length) * dofs + thin_mass(beam, length, mass_matrix) * field;
  const double along = lumped ? 0 : length;
  const double mass = beam.material.density * beam.section.area * along;
  const auto force = [&](int k) { return integrated(-ends[k], mass, {field[k], field[6 + k] - field[k]}); };
  SectionForces out;
  out.axial = force(0);
  out.shear_y = force(1);
  out.shear_z = force(2);
  out.torque = integrated(-ends[3], polar_inertia(beam) * along, {field[3]});
  out.moment_y = integrated(-ends[4], length, out.shear_z);
  out.moment_z = integrated(-ends[5], -length, out.shear_y);
  return out;
}

/// Of a beam with lumped masses the forces at its ends with these, linear between the two.
SectionForces forces_with_lumps(const BeamElement& beam, double length, const Vector12& dofs,
                                const Vector12& field) {
  const Vector12 ends =
      element_stiffness(beam, length) * dofs + thin_mass(beam, length, MassMatrix::lumped) * field;
  const auto linear = [&](int k) { return SectionForces::Polynomial{-ends[k], ends[6 + k] + ends[k]}; };
  return {.axial = linear(0), .shear_y = linear(1), .shear_z = linear(2)};
}

/// Rigid offsets o turn with the nodes: by θ × o and ½ θ × (θ × o), on which the forces at the ends work.
void add_offsets(const BeamElement& beam, const Matrix3d& axes, const SectionForces& forces,
                 Matrix12& stiffness) {
  for (std::size_t end = 0; end < 2; ++end) {
    if (beam.offsets[end].isZero(0)) continue;
    const auto at_end = [&](const SectionForces::Polynomial& p) {
      return end == 0 ? -p[0] : p[0] + p[1] + p[2] + p[3];
    };
    const Vector3d f(at_end(forces.axial), at_end(forces.shear_y), at_end(forces.shear_z)),
        o = axes.transpose() * beam.offsets[end];
    const Eigen::Index turn = 6 * static_cast<Eigen::Index>(end) + 3;
    stiffness.block<3, 3>(turn, turn) +=
        0.5 * (f * o.transpose() + o * f.transpose()) - f.dot(o) * Matrix3d::Identity();
  }
}

/// Loads as the beams see them: displacements by which they deform the beams, and the acceleration fields
/// that go with them (none for forces at the boundary).
struct Loads {
  MatrixXd displacements;  ///< 6·nodes × loads
  std::vector<Field> fields;
  VectorXd sizes;  ///< the largest force that each could cause, about
};

/// Adds the geometric stiffness of one beam, in the basis, for every load; to `reference` that of unit
/// tension.
void add_beam(const Mesh& mesh, int element, const Loads& loads, const MatrixXd& shapes,
              MassMatrix mass_matrix, std::vector<MatrixXd>& stiffness, MatrixXd& reference) {
  const BeamElement& beam = mesh.elements[element];
  const ElementGeometry geometry = element_geometry(mesh, element);
  const Matrix12 transformation = element_transformation(beam, geometry.axes);
  const ShearRatio shear = shear_ratio(beam, geometry.length);
  MatrixXd dofs(12, shapes.cols());
  for (int end = 0; end < 2; ++end) dofs.middleRows<6>(6 * end) = shapes.middleRows<6>(6 * beam.nodes[end]);
  dofs = (transformation * dofs).eval();
  const auto add = [&](const SectionForces& section, const SectionForces& at_ends, MatrixXd& sum) {
    Matrix12 k = element_geometric_stiffness(section, geometry.length, shear);
    add_offsets(beam, geometry.axes, at_ends, k);
    const MatrixXd forces = k * dofs;
    sum.noalias() += dofs.transpose() * forces;
  };
  add({.axial = {1}}, {.axial = {1}}, reference);
  for (Eigen::Index l = 0; l < loads.displacements.cols(); ++l) {
    const auto load = static_cast<std::size_t>(l);
    const Vector12 values = transformation * nodal_values(beam, loads.displacements.col(l)),
                   field = element_field(geometry, loads.fields[load]);
    const SectionForces section = section_forces(beam, geometry.length, values, field, mass_matrix);
    if (mass_matrix == MassMatrix::consistent)
      add(section, section, stiffness[load]);
    else
      add(section, forces_with_lumps(beam, geometry.length, values, field), stiffness[load]);
  }
}

/// Displacements by a unit force against the displacement of each boundary dof, all others free.
MatrixXd boundary_displacements(const Basis& basis, Eigen::Index count) {
  const Cholesky factor(basis.stiffness.topLeftCorner(count, count));
  if (!factor.ok())
    throw std::invalid_argument(
        "geometric stiffness: a part of the mesh is held by boundary dofs only, so that forces there have no "
        "static stress");
  return basis.shapes.leftCols(count) * factor.solve(MatrixXd::Identity(count, count));
}

/// About the distance over which a unit moment makes a pair of forces.
double extent(const Mesh& mesh) {
  return (mesh.nodes.rowwise().maxCoeff() - mesh.nodes.rowwise().minCoeff()).norm();
}

Loads all_loads(const Mesh& mesh, const ReductionOptions& options, const Basis& basis) {
  const auto unit = unit_fields();
  const Eigen::Index inertial = GeometricStiffness::boundary;
  const Eigen::Index boundary = static_cast<Eigen::Index>(options.boundary.size());
  Loads loads;
  loads.displacements.resize(basis.shapes.rows(), inertial + boundary);
  loads.displacements.leftCols(inertial) = basis.responses;
  if (boundary > 0) loads.displacements.rightCols(boundary) = boundary_displacements(basis, boundary);
  loads.fields.assign(unit.begin(), unit.end());
  loads.fields.resize(static_cast<std::size_t>(inertial + boundary));
  loads.sizes.resize(inertial + boundary);
  const MatrixXd forces = unit_inertia_forces(mesh, options.mass_matrix);
  for (Eigen::Index l = 0; l < inertial; ++l) {
    loads.sizes[l] = 0;
    for (Eigen::Index node = 0; node < mesh.nodes.cols(); ++node)
      loads.sizes[l] += forces.col(l).segment<3>(6 * node).norm();
  }
  for (Eigen::Index b = 0; b < boundary; ++b)
    loads.sizes[inertial + b] =
        options.boundary[static_cast<std::size_t>(b)].rotation ? 1 / extent(mesh) : 1.0;
  return loads;
}

}  // namespace

MatrixXd unit_inertia_forces(const Mesh& mesh, MassMatrix mass_matrix) {
  const auto fields = unit_fields();
  MatrixXd forces = MatrixXd::Zero(6 * mesh.nodes.cols(), GeometricStiffness::boundary);
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const BeamElement& beam = mesh.elements[e];
    const ElementGeometry geometry = element_geometry(mesh, e);
    const Matrix12 transformation = element_transformation(beam, geometry.axes);
    const Matrix12 mass = thin_mass(beam, geometry.length, mass_matrix);
    for (std::size_t l = 0; l < fields.size(); ++l) {
      const Vector12 force = -transformation.transpose() * (mass * element_field(geometry, fields[l]));
      for (int end = 0; end < 2; ++end)
        forces.col(static_cast<Eigen::Index>(l)).segment<6>(6 * beam.nodes[end]) += force.segment<6>(6 * end);
    }
  }
  return forces;
}

GeometricStiffness geometric_stiffness(const Mesh& mesh, const ReductionOptions& options,
                                       const Basis& basis) {
  const Loads loads = all_loads(mesh, options, basis);
  const Eigen::Index modes = basis.shapes.cols();
  std::vector<MatrixXd> stiffness(loads.fields.size(), MatrixXd::Zero(modes, modes));
  MatrixXd reference = MatrixXd::Zero(modes, modes);
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e)
    add_beam(mesh, e, loads, basis.shapes, options.mass_matrix, stiffness, reference);

  GeometricStiffness out;
  out.boundary_loads.resize(0, modes);
  const double largest = modes > 0 ? reference.cwiseAbs().maxCoeff() : 0;
  for (int l = 0; l < static_cast<int>(stiffness.size()); ++l) {
    MatrixXd& k = stiffness[static_cast<std::size_t>(l)];
    if (modes == 0 || !(k.cwiseAbs().maxCoeff() > negligible_stiffness * largest * loads.sizes[l])) continue;
    int load = l;
    if (l >= GeometricStiffness::boundary) {
      const Eigen::Index row = out.boundary_loads.rows();
      out.boundary_loads.conservativeResize(row + 1, modes);
      out.boundary_loads.row(row) = basis.stiffness.row(l - GeometricStiffness::boundary);
      load = GeometricStiffness::boundary + static_cast<int>(row);
    }
    out.loads.push_back(load);
    out.stiffness.push_back(0.5 * (k + k.transpose()));
  }
  return out;
}

}  // namespace mimbre::fe
