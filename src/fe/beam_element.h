#pragma once
#include <Eigen/Core>
#include <array>

#include "mimbre/fe.h"

/// The Euler–Bernoulli beam element. Element dofs, per end: translations u, v, w along and rotations about
/// the element's axes x (along the beam), y, z; the first end's six, then the second's. Axial displacement
/// and twist are linear, bending is cubic (Hermite), with θz = v' and θy = −w'.
namespace mimbre::fe {

using Matrix12 = Eigen::Matrix<double, 12, 12>;

struct ElementGeometry {
  Eigen::Vector3d start = Eigen::Vector3d::Zero();     ///< first end of the elastic axis, body axes
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns: element x, y, z in body axes
  double length = 0;
};

/// Throws std::invalid_argument naming the element when its nodes, length, axes, section or material are
/// unsound.
ElementGeometry element_geometry(const Mesh& mesh, int element);

/// Stiffness in element dofs (Przemieniecki 1968, 5.116, without shear).
Matrix12 element_stiffness(const BeamElement& element, double length);

/// Consistent mass in element dofs (Przemieniecki 1968, 11.21, without shear and bending rotary inertia):
/// bending and stretching at ρA, twisting at ρ(Iy + Iz).
Matrix12 element_mass(const BeamElement& element, double length);

/// Polar mass inertia of the section per length, ρ(Iy + Iz).
double polar_inertia(const BeamElement& element);

/// An axial force (tension positive) along the element: N(ξ) = Σ coefficients[k] ξ^k, N.
using AxialForce = std::array<double, 3>;

/// ∫ N (v'² + w'²) ds in element dofs: the geometric stiffness of a tie with the cubic displacements
/// (Przemieniecki 1968, 15.3, for constant N).
Matrix12 element_geometric_stiffness(const AxialForce& force, double length);

/// Element dofs = transformation · nodal dofs (body axes): the rigid offsets, then the element's axes.
Matrix12 element_transformation(const BeamElement& element, const Eigen::Matrix3d& axes);

/// Displacement of the axis at `xi` in [0, 1] (element axes) = shape functions · element dofs.
Eigen::Matrix<double, 3, 12> shape_functions(double xi, double length);

}  // namespace mimbre::fe
