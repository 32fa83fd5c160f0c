#pragma once
#include <Eigen/Core>
#include <vector>

#include "mimbre/fe_mesh.h"

namespace mimbre::fe {

/// A stiff part that moves with a node.
struct LumpedMass {
  int node = 0;
  double mass = 0;                                   ///< kg
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< m, from the node to its centre of mass, body axes
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  ///< ∫ d dᵀ dm about its centre of mass, kg m²
  /// Inertia against turning beyond that of `second`: of the twist of slender beams, kg m².
  Eigen::Matrix3d twist = Eigen::Matrix3d::Zero();
};

/// Of all elements and point masses of a mesh, see lump_masses; errors as there.
std::vector<LumpedMass> lumped_masses(const SolidMesh& mesh);

}  // namespace mimbre::fe
