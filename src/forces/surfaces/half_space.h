#pragma once
#include "compile/compiled.h"
#include "forces/surfaces/drawing.h"
#include "forces/surfaces/touch.h"
#include "spec/surface_kind.h"

namespace mimbre::surfaces {

/// All below z = 0.
struct HalfSpace {
  template <class T>
  static Touch<T> touch(const SurfaceData&, const Vec3<T>& p) {
    return {p[2], Vec3<T>::UnitZ()};
  }
  static void draw(const spec::Surface&, const spec::Pose& pose, double width, BodyDrawing& body) {
    const double thick = 0.01 * width;
    draw_shape(spec::Shape::Kind::box, shifted(pose, -0.5 * thick), {width, width, thick}, body);
  }
  static constexpr SurfaceInfo info{.name = "half_space", .one_sided = true, .draw = draw};
};

}  // namespace mimbre::surfaces
