#pragma once
#include "compile/compiled.h"
#include "forces/surfaces/drawing.h"
#include "forces/surfaces/touch.h"
#include "spec/surface_kind.h"

namespace mimbre::surfaces {

/// About the origin; `size`: radius.
struct Sphere {
  template <class T>
  static Touch<T> touch(const SurfaceData& s, const Vec3<T>& p) {
    return mimbre::surfaces::ball(p, T(s.size[0]));
  }
  static void draw(const spec::Surface& s, const spec::Pose& pose, double, BodyDrawing& body) {
    draw_shape(spec::Shape::Kind::sphere, pose, {s.size[0], 0, 0}, body);
  }
  static constexpr SurfaceInfo info{.name = "sphere", .sizes = {"radius"}, .ball = true, .draw = draw};
};

}  // namespace mimbre::surfaces
