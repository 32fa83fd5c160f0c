#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "mimbre/fe_mesh.h"

namespace mimbre::fe {

/// Corner faces that only one solid has, turned outwards, as triangles (quadrilaterals are split); shells'
/// faces as they are.
struct Skin {
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::array<int, 2>> edges;  ///< of the faces, each once
  bool closed = true;                     ///< solids alone
};
Skin skin(const SolidMesh& mesh);

/// Volume and its centre of what a closed skin encloses (flat facets).
struct Enclosed {
  double volume = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
};
Enclosed enclosed(const SolidMesh& mesh, const Skin& skin);

/// A wire frame of at most about `most` nodes: the skin's nodes thinned on a grid, their edges kept.
struct Wire {
  std::vector<int> nodes;                 ///< of the mesh
  std::vector<std::array<int, 2>> lines;  ///< indices into nodes
};
Wire wire(const SolidMesh& mesh, const Skin& skin, int most);

}  // namespace mimbre::fe
