#pragma once
#include <array>

#include "compile/compiled.h"
#include "forces/surfaces/drawing.h"
#include "forces/surfaces/touch.h"
#include "spec/surface_kind.h"

namespace mimbre::surfaces {

/// About the origin; `size`: edges along x, y, z.
struct Box {
  template <class T>
  static Touch<T> touch(const SurfaceData& s, const Vec3<T>& p) {
    std::array<T, 3> out;
    std::array<Vec3<T>, 3> normals;
    for (int k = 0; k < 3; ++k) {
      const T side = select(p[k] < T(0), T(-1), T(1));
      out[static_cast<std::size_t>(k)] = side * p[k] - T(0.5 * s.size[k]);
      normals[static_cast<std::size_t>(k)] = side * Vec3<T>::Unit(k);
    }
    return convex<3>(out, normals);
  }
  static void draw(const spec::Surface& s, const spec::Pose& pose, double, BodyDrawing& body) {
    draw_shape(spec::Shape::Kind::box, pose, s.size, body);
  }
  static constexpr SurfaceInfo info{.name = "box", .sizes = {"size"}, .draw = draw};
};

}  // namespace mimbre::surfaces
