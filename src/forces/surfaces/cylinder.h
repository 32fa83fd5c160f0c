#pragma once
#include <array>

#include "compile/compiled.h"
#include "forces/surfaces/drawing.h"
#include "forces/surfaces/touch.h"
#include "spec/surface_kind.h"

namespace mimbre::surfaces {

/// About the z axis and the origin; `size`: radius, length.
struct Cylinder {
  template <class T>
  static Touch<T> touch(const SurfaceData& s, const Vec3<T>& p) {
    const Touch<T> round = ball(Vec3<T>(p[0], p[1], T(0)), T(s.size[0]));
    // On the axis itself any radial direction is as good as another.
    Vec3<T> radial(round.normal[0], round.normal[1], T(0));
    radial[0] = select(round.normal[2] > T(0.5), T(1), radial[0]);
    const T side = select(p[2] < T(0), T(-1), T(1));
    return convex<2>(std::array<T, 2>{round.distance, side * p[2] - T(0.5 * s.size[1])},
                     std::array<Vec3<T>, 2>{radial, side * Vec3<T>::UnitZ()});
  }
  static void draw(const spec::Surface& s, const spec::Pose& pose, double, BodyDrawing& body) {
    draw_shape(spec::Shape::Kind::cylinder, pose, {s.size[0], s.size[1], 0}, body);
  }
  static constexpr SurfaceInfo info{.name = "cylinder", .sizes = {"radius", "length"}, .draw = draw};
};

}  // namespace mimbre::surfaces
