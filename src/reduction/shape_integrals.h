#pragma once
#include <Eigen/Core>

#include "mimbre/beam_reduction.h"
#include "mimbre/reduced_body.h"

namespace mimbre::fe {

/// Fills the body's mass, first and second moments, S, S_position, S_modes from the mesh and the mode shapes
/// (6·nodes × modes). Gauss quadrature, exact for the elements' shape functions.
///
/// Sections have the polar inertia that the consistent mass matrix gives them, j = ρ(Iy + Iz) about the
/// element's axis a, and no diametral one, so that rigid motions, modes and their coupling have the kinetic
/// energy of the finite-element model:
/// - second_moment contains ∫ j (½ I − a aᵀ) dx, whose inertia tensor tr(P̄) I − P̄ is ∫ j a aᵀ dx;
/// - S_position contains ½ ε_kij c, c_k = ∫ j a_k (aᵀ X_theta) dx: antisymmetric in i, j, so it acts on the
/// coupling of
///   angular velocity and modes only, not on the deformed second moment;
/// - S_modes has no such term; that of the modes among themselves is in mass_matrix.
/// Where the theory gives them rotary inertia, they turn with the modes as the stiff plates that they are, to
/// second order, which gyroscopic moments need: with D = ∫ρ d dᵀ over the section and θ = X_theta y
/// - second_moment contains ∫ D dx, S_position row j of i (D θ~ᵀ)_ij;
/// - S_modes contains (θ~ D θ~ᵀ)_ij + ½ (θ~² D + D θ~²)_ij, the latter symmetric in the two modes. It acts on
/// the deformed second moment; what it would add to the mass of the modes is left out of mass_matrix.
/// Lumped masses are points at the ends of the elements, with the sections' inertia there and that against
/// bending as a stiff rod along the element, D = (m L²/78) a aᵀ at each end.
void add_shape_integrals(const Mesh& mesh, const Eigen::MatrixXd& shapes, MassMatrix mass_matrix,
                         ReducedBody& body);

/// The same point by point: zeros, then (3.6), (3.9)–(3.11) at each point with mass `dm`, undeformed
/// `position` and modes X (3 × modes), at last the blocks of S_modes that follow by symmetry.
void clear_shape_integrals(ReducedBody& body, Eigen::Index modes);
void add_mass_point(ReducedBody& body, double dm, const Eigen::Vector3d& position, const Eigen::Matrix3Xd& X);
/// A stiff part that turns by θ = `turn` · y about a point of the body: D = ∫d dᵀ dm over its points d.
void add_turning_part(ReducedBody& body, const Eigen::Matrix3d& D, const Eigen::Matrix3Xd& turn);
void complete_shape_integrals(ReducedBody& body);

}  // namespace mimbre::fe
