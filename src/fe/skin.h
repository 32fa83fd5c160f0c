#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "mimbre/fe_mesh.h"

namespace mimbre::fe {

/// Corner faces that only one solid has, turned outwards, as triangles (quadrilaterals are split).
struct Skin {
  std::vector<std::array<int, 3>> triangles;
  bool closed = true;  ///< solids alone
};
Skin skin(const SolidMesh& mesh);

/// Volume and its centre of what a closed skin encloses (flat facets).
struct Enclosed {
  double volume = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
};
Enclosed enclosed(const SolidMesh& mesh, const Skin& skin);

}  // namespace mimbre::fe
