#include "reduction/geometric_stiffness.h"

#include <Eigen/Core>
#include <array>
#include <stdexcept>

#include "fe/beam_element.h"
#include "math/decompositions.h"

namespace mimbre::fe {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Vector12 = Eigen::Matrix<double, 12, 1>;

/// A prestress below this part of what its load could cause at most is round-off.
constexpr double negligible = 1e-7;

/// Acceleration of the body's points: constant + gradient r̄.
struct Field {
  Vector3d constant = Vector3d::Zero();
  Matrix3d gradient = Matrix3d::Zero();
};

Matrix3d cross_matrix(const Vector3d& a) {
  Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

/// Of the unit loads of inertia, in the order of GeometricStiffness: a + α × r̄ + ω × (ω × r̄).
std::array<Field, GeometricStiffness::boundary> unit_fields() {
  std::array<Field, GeometricStiffness::boundary> fields;
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    fields[k].gradient = Vector3d::Unit(k) * Vector3d::Unit(k).transpose() - Matrix3d::Identity();
    Matrix3d& mixed = fields[3 + k].gradient;  // xy, yz, xz
    mixed(k, next) = mixed(next, k) = 1;
    fields[GeometricStiffness::acceleration + k].constant = Vector3d::Unit(k);
    fields[GeometricStiffness::angular_acceleration + k].gradient = cross_matrix(Vector3d::Unit(k));
  }
  return fields;
}

/// The field as element dofs of a beam: exactly, since it is linear along the axis.
Vector12 element_field(const ElementGeometry& g, const Field& field) {
  const Matrix3d gradient = g.axes.transpose() * field.gradient * g.axes;
  const Vector3d start = g.axes.transpose() * (field.constant + field.gradient * g.start);
  const double twist = 0.5 * (gradient(2, 1) - gradient(1, 2));
  Vector12 dofs;
  for (int end = 0; end < 2; ++end)
    dofs.segment<6>(6 * end) << start + end * g.length * gradient.col(0), twist, -gradient(2, 0),
        gradient(1, 0);
  return dofs;
}

Vector12 nodal_values(const BeamElement& beam, const VectorXd& displacement) {
  Vector12 values;
  for (int end = 0; end < 2; ++end) values.segment<6>(6 * end) = displacement.segment<6>(6 * beam.nodes[end]);
  return values;
}

/// Axial force of a beam: the mean by its stretch, which consistent forces make exact; along it as the
/// inertia force of the field, −ρA times its axial component, changes it.
AxialForce axial_force(const BeamElement& beam, double length, const Vector12& dofs, const Vector12& field) {
  const double mean = beam.material.young * beam.section.area * (dofs[6] - dofs[0]) / length;
  const double mass = beam.material.density * beam.section.area * length;
  const double first = mass * field[0], second = 0.5 * mass * (field[6] - field[0]);
  return {mean - first / 2 - second / 3, first, second};
}

/// Loads as the beams see them: displacements by which they stretch the beams, and the acceleration fields
/// that go with them (none for forces at the boundary).
struct Loads {
  MatrixXd displacements;  ///< 6·nodes × loads
  std::vector<Field> fields;
  VectorXd sizes;  ///< the largest axial force that each could cause, about
};

/// Adds the geometric stiffness of one beam, in the basis, for every load; to `reference` that of unit
/// tension.
void add_beam(const Mesh& mesh, int element, const Loads& loads, const MatrixXd& shapes,
              std::vector<MatrixXd>& stiffness, MatrixXd& reference) {
  const BeamElement& beam = mesh.elements[element];
  const ElementGeometry geometry = element_geometry(mesh, element);
  const Matrix12 transformation = element_transformation(beam, geometry.axes);
  const ShearRatio shear = shear_ratio(beam, geometry.length);
  MatrixXd dofs(12, shapes.cols());
  for (int end = 0; end < 2; ++end) dofs.middleRows<6>(6 * end) = shapes.middleRows<6>(6 * beam.nodes[end]);
  dofs = (transformation * dofs).eval();
  const auto add = [&](const AxialForce& force, MatrixXd& sum) {
    const MatrixXd forces = element_geometric_stiffness(force, geometry.length, shear) * dofs;
    sum.noalias() += dofs.transpose() * forces;
  };
  add({1, 0, 0}, reference);
  for (Eigen::Index l = 0; l < loads.displacements.cols(); ++l)
    add(axial_force(beam, geometry.length, transformation * nodal_values(beam, loads.displacements.col(l)),
                    element_field(geometry, loads.fields[static_cast<std::size_t>(l)])),
        stiffness[static_cast<std::size_t>(l)]);
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
  const MatrixXd forces = unit_inertia_forces(mesh);
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

MatrixXd unit_inertia_forces(const Mesh& mesh) {
  const auto fields = unit_fields();
  MatrixXd forces = MatrixXd::Zero(6 * mesh.nodes.cols(), GeometricStiffness::boundary);
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const BeamElement& beam = mesh.elements[e];
    const ElementGeometry geometry = element_geometry(mesh, e);
    const Matrix12 transformation = element_transformation(beam, geometry.axes);
    // Along the axis only: couples of turning sections bend the bars and stretch them next to nothing.
    BeamElement thin = beam;
    thin.theory = BeamTheory::euler_bernoulli;
    const Matrix12 mass = element_mass(thin, geometry.length);
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
    add_beam(mesh, e, loads, basis.shapes, stiffness, reference);

  GeometricStiffness out;
  out.boundary_loads.resize(0, modes);
  const double largest = modes > 0 ? reference.cwiseAbs().maxCoeff() : 0;
  for (int l = 0; l < static_cast<int>(stiffness.size()); ++l) {
    MatrixXd& k = stiffness[static_cast<std::size_t>(l)];
    if (modes == 0 || !(k.cwiseAbs().maxCoeff() > negligible * largest * loads.sizes[l])) continue;
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
