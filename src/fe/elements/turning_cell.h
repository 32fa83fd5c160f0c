#pragma once
#include <Eigen/Core>

#include "fe/elements/mesh_cells.h"

/// What displacements are to the second order in the axes of an element that turns with its nodes: there a
/// body that bends without stretching stays as long as it was, whatever element it is made of.
///
/// With r the nodes' arms from the element's centre, u and θ their displacements and rotations and ω the
/// element's mean rotation, all linear in some fields, the nodes move to the second order by
///   displacement  −ω × u + ½ ω × (ω × r),   rotation  −½ ω × θ
/// and the ends of a bar, which the bow of the bar brings nearer, along it by ∓ ½ b,
///   b = l/30 (2 φ₁² − φ₁ φ₂ + 2 φ₂²),   φ: turns of the ends across the bar, against ω.
namespace mimbre::fe {

struct TurningCell {
  Eigen::MatrixXd stiffness;  ///< of its own dofs
  Eigen::MatrixXd to_own;     ///< own dofs by those of the nodes; empty: these are its own
  Eigen::Matrix3Xd arms;      ///< of its nodes
  Eigen::MatrixXd turn;       ///< 3 × own dofs: ω
  int node_dofs = 3;          ///< 6: with rotations
  double bar = 0;             ///< length of a bar; 0: no bar

  Eigen::Index dofs() const { return stiffness.rows(); }
  /// Rows of motions().
  int motions_size() const { return bar > 0 ? 7 : 3; }
};

TurningCell turning_beam(const Mesh& beams, int number);

/// Of any element. `beams`: those of the mesh, as the functions for beams take them.
TurningCell turning_cell(const SolidMesh& mesh, const MeshCells& cells, const Mesh& beams, int number);

/// By fields u (own dofs × fields): ω, and of a bar φ₁, φ₂.
Eigen::MatrixXd motions(const TurningCell& cell, const Eigen::MatrixXd& u);

/// Own dofs of second order by field a and field b together: those of both at once, less those of each,
/// halved.
Eigen::VectorXd second_order(const TurningCell& cell, const Eigen::MatrixXd& u,
                             const Eigen::MatrixXd& motions, Eigen::Index a, Eigen::Index b);

/// P with  work of own forces on the dofs of second order of any field z = ½ zᵀ (mᵀ P + Pᵀ m) z,  m =
/// motions.
Eigen::MatrixXd work_partner(const TurningCell& cell, const Eigen::VectorXd& forces, const Eigen::MatrixXd& u,
                             const Eigen::MatrixXd& motions);

/// S with ½ θᵀ S θ the work of forces f (3 × points) on the displacements ½ θ × (θ × r) of points at arms r.
Eigen::Matrix3d turning_work(const Eigen::Matrix3Xd& forces, const Eigen::Matrix3Xd& arms);

}  // namespace mimbre::fe
