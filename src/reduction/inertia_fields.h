#pragma once
#include <Eigen/Core>
#include <array>

#include "fe/elements/beam_element.h"
#include "mimbre/reduced_body.h"

/// Acceleration fields of a rigid motion, as beams see them.
namespace mimbre::fe {

using Vector12 = Eigen::Matrix<double, 12, 1>;

/// Acceleration of the body's points: constant + gradient r̄.
struct Field {
  Eigen::Vector3d constant = Eigen::Vector3d::Zero();
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
};

/// Of the unit loads of inertia, in the order of GeometricStiffness: a + α × r̄ + ω × (ω × r̄).
std::array<Field, GeometricStiffness::boundary> unit_fields();

/// The field as element dofs of a beam: exactly, since it is linear along the axis.
Vector12 element_field(const ElementGeometry& geometry, const Field& field);

/// Mass of a beam without couples of turning sections, which bend the bars and stress them next to nothing.
Matrix12 thin_mass(BeamElement beam, double length, MassMatrix mass_matrix);

}  // namespace mimbre::fe
