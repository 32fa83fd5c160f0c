#include "reduction/inertia_fields.h"

#include "math/cross_matrix.h"

namespace mimbre::fe {

using Eigen::Matrix3d;
using Eigen::Vector3d;

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

Matrix12 thin_mass(BeamElement beam, double length, MassMatrix mass_matrix) {
  beam.theory = BeamTheory::euler_bernoulli;
  return element_mass(beam, length, mass_matrix);
}

}  // namespace mimbre::fe
