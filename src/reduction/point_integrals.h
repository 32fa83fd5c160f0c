#pragma once
#include <Eigen/Core>
#include <vector>

#include "mimbre/fe_mesh.h"
#include "mimbre/reduced_body.h"

namespace mimbre::fe {

/// Shape integrals of a mesh whose mass does not move as its nodes do alone (shells, beams, masses with an
/// extent): sums over the points that carry it. Mass, inertia and the modes' mass matrix then belong to one
/// and the same motion of points, and no motion has a negative kinetic energy.
void add_point_integrals(const SolidMesh& mesh, const std::vector<Dof>& dofs, const Eigen::MatrixXd& shapes,
                         ReducedBody& body);

/// The same of masses that are lumped at the nodes.
void add_lumped_integrals(const SolidMesh& mesh, const std::vector<Dof>& dofs, const Eigen::MatrixXd& shapes,
                          ReducedBody& body);

}  // namespace mimbre::fe
