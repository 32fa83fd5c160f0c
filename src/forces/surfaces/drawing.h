#pragma once
#include <array>
#include <vector>

#include "mimbre/channels.h"
#include "roads/grid.h"

/// How surfaces are drawn.
namespace mimbre::surfaces {

inline spec::Pose shifted(const spec::Pose& pose, double along_z) {
  return {pose.position + along_z * pose.rotation.col(2), pose.rotation};
}

inline void draw_shape(spec::Shape::Kind kind, const spec::Pose& pose, const Eigen::Vector3d& size,
                       BodyDrawing& body) {
  body.shapes.push_back({kind, pose, size});
}

/// Triangles go to the points of a body that has no modes.
void draw_triangles(const std::vector<Eigen::Vector3d>& vertices,
                    const std::vector<std::array<int, 3>>& triangles, const spec::Pose& pose,
                    BodyDrawing& body);

/// Of large grids only the rows and columns where they bend, or, where they do all over, every so many.
void draw_heights(const Eigen::MatrixXd& heights, const Eigen::Vector2d& spacing, const spec::Pose& pose,
                  BodyDrawing& body);

/// A road along a line, as wheels feel it (roads/grid.h).
void draw_along_line(const RoadGrid& road, BodyDrawing& body);

}  // namespace mimbre::surfaces
