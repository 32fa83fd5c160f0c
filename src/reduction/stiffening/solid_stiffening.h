#pragma once
#include "mimbre/fe_mesh.h"
#include "mimbre/reduced_body.h"

namespace mimbre::fe {

/// Forces on the dofs (rows) by the unit loads of inertia of GeometricStiffness (columns): minus mass times
/// the acceleration of the undeformed body's points. Solids: three dofs per node.
Eigen::MatrixXd unit_inertia_forces(const SolidMesh& mesh, const FeMatrices& matrices);

/// Geometric stiffness of a body of solids in the modes `shapes` (dofs × modes), by its stress under
/// - the unit loads of inertia, with displacements `responses` (dofs × 12), the interfaces held;
/// - unit forces against its static modes, the first `statics` of the shapes, all others free; `stiffness` is
///   that of all shapes.
/// Loads that stiffen nothing are left out. Throws std::invalid_argument for shells and beams.
GeometricStiffness solid_stiffening(const SolidMesh& mesh, const Eigen::MatrixXd& responses,
                                    const Eigen::MatrixXd& shapes, const Eigen::MatrixXd& stiffness,
                                    Eigen::Index statics);

}  // namespace mimbre::fe
