#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

namespace mimbre::results {

/// Edges of a surface that are worth a line: where two triangles meet at more than 30°, where one ends or
/// more than two meet. Ascending pairs, each once.
std::vector<std::array<int, 2>> feature_edges(const Eigen::Matrix3Xd& points,
                                              const std::vector<std::array<int, 3>>& triangles);

/// Of `lines` those that are no edge of a triangle.
std::vector<std::array<int, 2>> free_lines(const std::vector<std::array<int, 2>>& lines,
                                           const std::vector<std::array<int, 3>>& triangles);

/// A drawing with fewer points; triangles and lines hold places in `points`.
struct ThinSurface {
  std::vector<int> points;  ///< those kept, ascending, by their numbers before
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::array<int, 2>> lines, edges;
};

/// Lets a grid's cell keep one of its points, the one of the largest weight (the first of equals; without
/// weights the first): `most` points at most, where the directions that a surface faces, its edges and lines
/// leave that many cells, apart from each other so that the sides of a thin wall do not become one. What has
/// lost its extent is left out. At most `most` points stay as they are, with all that is drawn of them; of
/// more those that no triangle or line has are dropped. Needs most ≥ 64; weights: one per point, or none.
ThinSurface thin_surface(const Eigen::Matrix3Xd& points, const std::vector<std::array<int, 3>>& triangles,
                         const std::vector<std::array<int, 2>>& lines, int most,
                         const Eigen::Ref<const Eigen::VectorXd>& weights = Eigen::VectorXd());

}  // namespace mimbre::results
