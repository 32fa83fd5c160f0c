#pragma once
#include <string>
#include <vector>

#include "compile/compiled.h"
#include "spec/closed_surface.h"

namespace mimbre {

/// Triangles with what it takes to find the nearest point on them.
TriangleMesh triangle_mesh(const std::vector<Vec3d>& vertices,
                           const std::vector<std::array<int, 3>>& triangles);

/// The ground of a grid of heights (spec::Surface::heights), two triangles a cell; its border goes on to
/// where nothing comes.
TriangleMesh height_mesh(const Eigen::MatrixXd& heights, const Eigen::Vector2d& spacing);

}  // namespace mimbre
