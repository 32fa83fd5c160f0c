#pragma once
#include <Eigen/Core>
#include <array>

#include "mimbre/fe.h"

/// The beam element. Element dofs, per end: translations u, v, w along and rotations about the element's axes
/// x (along the beam), y, z; the first end's six, then the second's. Axial displacement and twist are linear,
/// bending is cubic (Hermite), with θz = v' and θy = −w'. With shear (Timoshenko) the cubic deflection and
/// the quadratic rotation of the section depend on one another by Φ such that they are those of an unloaded
/// bar (Friedman, Kosmatka 1993): at its nodes the element is exact in statics, and it does not lock.
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

/// Φ = 12 EI/(kGA L²) for bending in the element's x–y and x–z planes; zero without shear.
struct ShearRatio {
  double xy = 0, xz = 0;
};
ShearRatio shear_ratio(const BeamElement& element, double length);

/// Stiffness in element dofs (Przemieniecki 1968, 5.116).
Matrix12 element_stiffness(const BeamElement& element, double length);

/// Consistent mass in element dofs: bending and stretching at ρA, twisting at ρ(Iy + Iz) (Przemieniecki 1968,
/// 11.21, without shear and rotary inertia), and turning of the sections at ρIy and ρIz where the theory has
/// it.
Matrix12 element_mass(const BeamElement& element, double length);
/// Consistent, or lumped: diagonal, see MassMatrix.
Matrix12 element_mass(const BeamElement& element, double length, MassMatrix mass_matrix);
/// Of each end of a beam with lumped masses: inertia against bending beside that of the sections, m L²/78.
double lumped_turning(const BeamElement& element, double length);

/// Polar mass inertia of the section per length, ρ(Iy + Iz).
double polar_inertia(const BeamElement& element);

/// Whether sections have inertia against turning with the bending.
bool has_rotary_inertia(const BeamElement& element);

/// Stress resultants along the element, element axes, on the section whose outer normal is x: a polynomial
/// Σ coefficients[k] ξ^k each, N and N m.
struct SectionForces {
  using Polynomial = std::array<double, 4>;
  Polynomial axial{};                 ///< tension positive
  Polynomial shear_y{}, shear_z{};    ///< their lines of action through the axis
  Polynomial torque{};                ///< about x
  Polynomial moment_y{}, moment_z{};  ///< EI θy', EI θz'
};

/// What the stress of the section forces adds to the stiffness, in element dofs whose rotations are the
/// nodes' rotation vectors (symmetric): the second variation of ∫ F·Γ + M·κ ds at constant forces F and
/// moments M, Γ and κ the strains of the geometrically exact beam (Reissner 1981; Simo, Vu-Quoc 1986) with
/// the element's displacements. It couples bending and twist. Only tension does work on the whole slope,
/// shear included (Engesser). Sections are taken as symmetric, and what a tension does as it untwists them is
/// left out.
Matrix12 element_geometric_stiffness(const SectionForces& forces, double length,
                                     const ShearRatio& shear = {});

/// Element dofs = transformation · nodal dofs (body axes): the rigid offsets, then the element's axes.
Matrix12 element_transformation(const BeamElement& element, const Eigen::Matrix3d& axes);

/// Displacement of the axis at `xi` in [0, 1] (element axes) = shape functions · element dofs.
Eigen::Matrix<double, 3, 12> shape_functions(double xi, double length, const ShearRatio& shear = {});

/// Rotation vector of the section at `xi` (element axes) = rotation functions · element dofs.
Eigen::Matrix<double, 3, 12> rotation_functions(double xi, double length, const ShearRatio& shear = {});

}  // namespace mimbre::fe
