#pragma once
#include <Eigen/Core>

namespace mimbre::fe {

using PlaneNodes = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::ColMajor, 2, 4>;
using MembraneMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 12, 12>;

/// Plane stress membrane of constant thickness with rotations about its normal (drilling): dofs u, v, θ of
/// each node. Triangles: the optimal one for bending in its plane (Felippa 2003, "A study of optimal membrane
/// triangles with drilling freedoms"). Quadrilaterals: the mean of their two divisions into such triangles,
/// with the exact energy of bending as rectangles of any aspect ratio. `nodes` (2 × 3 or 2 × 4)
/// anticlockwise, convex, from any corner on. Symmetric, full storage.
MembraneMatrix membrane_stiffness(const PlaneNodes& nodes, double young, double poisson, double thickness);
/// The same of any material, with one share of bending for all its directions; `elastic`: stress by strain in
/// the plane (xx, yy, engineering xy).
MembraneMatrix membrane_stiffness(const PlaneNodes& nodes, const Eigen::Matrix3d& elastic, double thickness);

/// Mean strain (xx, yy, engineering xy) of the element = matrix (3 × dofs) · dofs.
Eigen::Matrix<double, 3, Eigen::Dynamic> membrane_strain(const PlaneNodes& nodes);

}  // namespace mimbre::fe
