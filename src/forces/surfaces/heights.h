#pragma once
#include "compile/triangle_mesh.h"
#include "forces/surfaces/mesh.h"

namespace mimbre::surfaces {

/// All below a grid of heights z over x and y; beyond its border the border goes on.
struct Heights {
  template <class T>
  static Touch<T> touch(const SurfaceData& s, const Vec3<T>& p) {
    return Mesh::touch(s, p);
  }
  static void check(const spec::Surface& s, const checks::CheckedItem& item) {
    item.positive("spacing along x", s.spacing[0]);
    item.positive("spacing along y", s.spacing[1]);
    if (s.heights.rows() < 2 || s.heights.cols() < 2)
      item.error(fmt::format("has a grid of {} x {} heights; at least 2 x 2 are needed", s.heights.rows(),
                             s.heights.cols()));
    else
      item.finite("heights", s.heights);
  }
  static TriangleMesh mesh(const spec::Surface& s) { return height_mesh(s.heights, s.spacing); }
  static void draw(const spec::Surface& s, const spec::Pose& pose, double, BodyDrawing& body) {
    draw_heights(s.heights, s.spacing, pose, body);
  }
  static constexpr SurfaceInfo info{
      .name = "heights", .grid = true, .check = check, .mesh = mesh, .draw = draw};
};

}  // namespace mimbre::surfaces
