#pragma once
#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "mimbre/reduced_body.h"

/// Shape integrals of meshes of any isoparametric elements, by matrix products with the mass matrix of the
/// mesh (Lugrís 2008, 3.4): positions and displacements are interpolated alike, and so integrals of their
/// products are sums over pairs of nodes, exactly.
namespace mimbre::fe {

/// Nodes × nodes: m_kl of a translational mass matrix (three dofs per node) whose blocks are m_kl I. Throws
/// std::invalid_argument when they are not, to 1e-6 of the largest entry.
Eigen::SparseMatrix<double> nodal_mass(const Eigen::SparseMatrix<double>& translational_mass);

/// Fills the body's mass, first and second moments, S, S_position, S_modes from node positions (3 × nodes,
/// body axes), the nodes' mass (nodes × nodes, kg) and their displacements per mode (3·nodes × modes). Throws
/// std::invalid_argument when the sizes do not match.
void add_shape_integrals(const Eigen::Matrix3Xd& nodes, const Eigen::SparseMatrix<double>& nodal_mass,
                         const Eigen::MatrixXd& node_shapes, ReducedBody& body);

}  // namespace mimbre::fe
