#pragma once
#include "compile/compiled.h"
#include "forces/surfaces/drawing.h"
#include "forces/surfaces/touch.h"
#include "spec/surface_kind.h"

namespace mimbre::surfaces {

/// About the z axis and the origin, with half spheres at its ends; `size`: radius, length between their
/// centres.
struct Capsule {
  template <class T>
  static Touch<T> touch(const SurfaceData& s, const Vec3<T>& p) {
    const T half(0.5 * s.size[1]);
    const T above = select(p[2] > half, half, p[2]);
    return ball(Vec3<T>(p[0], p[1], p[2] - select(above < -half, T(-half), above)), T(s.size[0]));
  }
  static void draw(const spec::Surface& s, const spec::Pose& pose, double, BodyDrawing& body) {
    for (const double end : {-0.5, 0.5})
      draw_shape(spec::Shape::Kind::sphere, shifted(pose, end * s.size[1]), {s.size[0], 0, 0}, body);
    draw_shape(spec::Shape::Kind::cylinder, pose, {s.size[0], s.size[1], 0}, body);
  }
  static constexpr SurfaceInfo info{.name = "capsule", .sizes = {"radius", "length"}, .draw = draw};
};

}  // namespace mimbre::surfaces
