#pragma once
#include <array>
#include <vector>

#include "mimbre/fe_mesh.h"

namespace mimbre::fe {

/// What is seen of a mesh, and where stress is largest: corners of the solids' outer faces, both sides of
/// shells, beams as lines.
struct Surface {
  std::vector<SurfacePoint> points;           ///< nodes ascending
  std::vector<std::array<int, 3>> triangles;  ///< of points, counterclockwise from outside
  std::vector<std::array<int, 2>> lines;      ///< of points: sharp edges, rims of shells, beams
};
Surface surface(const SolidMesh& mesh);

}  // namespace mimbre::fe
