#pragma once
#include <Eigen/Core>

#include "mimbre/beam_reduction.h"
#include "reduction/bases/craig_bampton.h"

namespace mimbre::fe {

/// Forces of inertia on the mesh's dofs (6·nodes × 12) by unit loads of inertia and gravity, numbered as in
/// GeometricStiffness.
Eigen::MatrixXd unit_inertia_forces(const Mesh& mesh, MassMatrix mass_matrix);

/// Geometric stiffness in the coordinates of a basis whose `responses` are those to
/// unit_inertia_forces(mesh, options.mass_matrix). Its stress has two parts that add up to that of the body:
/// of each unit load of inertia with the boundary held, and of a unit force at each boundary dof, which the
/// static modes carry. The load of a boundary dof is the force that the static modes put up against its
/// displacement. Loads that stress no bar are left out.
GeometricStiffness geometric_stiffness(const Mesh& mesh, const ReductionOptions& options, const Basis& basis);

}  // namespace mimbre::fe
