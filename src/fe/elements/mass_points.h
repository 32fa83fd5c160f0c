#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "mimbre/fe_mesh.h"

namespace mimbre::fe {

/// Points that carry the mass of a mesh: displaced by displacement fields by the shape functions of the
/// elements, so that the energy of the points in any motion of the body and its modes is that of the
/// elements. What the mass matrix has beyond them is positive: of drilling rotations, and of the twist of
/// slender beams.
struct MassPoints {
  Eigen::Matrix3Xd places;  ///< m
  Eigen::VectorXd masses;   ///< kg
  Eigen::MatrixXd shapes;   ///< 3·points × fields
};

/// Calls visit(points) for parts of the mesh. Rows of `fields` by `dofs`; what is missing is held.
void for_each_mass_points(const SolidMesh& mesh, const std::vector<Dof>& dofs, const Eigen::MatrixXd& fields,
                          const std::function<void(const MassPoints&)>& visit);

/// Whether displacements of nodes alone do not determine how the mass moves: the mesh has shells, beams or
/// masses with an extent.
bool has_rotating_mass(const SolidMesh& mesh);

/// Of the mesh's point masses by the six dofs of their nodes.
std::vector<Eigen::Matrix<double, 6, 6>> point_mass_matrices(const SolidMesh& mesh);

/// Volume of the elements.
double element_volume(const SolidMesh& mesh);

}  // namespace mimbre::fe
