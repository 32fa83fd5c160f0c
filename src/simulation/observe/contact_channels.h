#pragma once
#include "dynamics/relative/workspace.h"

namespace mimbre {

/// What the pairs of a contact that touch do, in sum.
struct ContactSum {
  Vec3d force = Vec3d::Zero();        ///< N, global axes
  double normal = 0, tangential = 0;  ///< N, of the magnitudes
  double depth = 0;                   ///< m, the largest
  int count = 0;
};

/// Of all pairs of a contact of the spec, the force on their spheres (of two spheres on the second); or with
/// `body`, of the tree, of those that press on it, the force on it. After the forces.
ContactSum contact_sum(const Compiled& model, const relative::Workspace<double>& work, int contact,
                       int body = -1);

}  // namespace mimbre
