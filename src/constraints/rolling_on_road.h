#pragma once
#include <fmt/format.h>

#include <limits>

#include "constraints/equation_context.h"
#include "constraints/rolling.h"
#include "forces/road_surface.h"
#include "math/choice.h"

namespace mimbre::constraints {

/// b, a wheel as of Rolling, rolls without slip on a road over a grid; a is on the ground.
struct RollingOnRoad {
  static constexpr ConstraintInfo info = [] {
    ConstraintInfo of = Rolling::info;
    of.name = "rolling_on_road";
    of.axes = 1;
    of.two_places = false;
    of.on_road = true;
    return of;
  }();
  /// Behind the numbers: a's global position, and its axes column by column.
  static constexpr int position = 2, axes = 5;

  /// With the road's height h, its slopes, and their derivatives.
  template <class T>
  struct Ground {
    T height;
    Vec3<T> normal, by_x, by_y;  ///< N = (−∂h/∂x, −∂h/∂y, 1), and its derivatives
  };
  template <class T>
  static Ground<T> ground_at(const RoadData& road, const T& x, const T& y) {
    const roads::Bend<T> at = roads::bend(road, x, y);
    return {at.z, Vec3<T>(-at.x, -at.y, T(1)), Vec3<T>(-at.xx, -at.xy, T(0)), Vec3<T>(-at.xy, -at.yy, T(0))};
  }

  /// The point of the wheel whose tangent plane has a normal, from the centre: ρ = R (z e − n)/s − crown n,
  /// with z = n · e, s = |n × e| and the ring's radius R.
  template <class T>
  struct Rim {
    T ring, crown;
    Vec3<T> e, n, along;  ///< z e − n
    T size, z, s;         ///< |N|, n · e, s

    Rim(const T& ring_radius, const T& crown_radius, const Vec3<T>& axis, const Vec3<T>& normal)
        : ring(ring_radius), crown(crown_radius), e(axis) {
      using std::sqrt;
      size = sqrt(normal.squaredNorm());
      n = normal / size;
      z = n.dot(e);
      along = z * e - n;
      const T square = T(1) - z * z;
      s = sqrt(select(square > T(least_tilt), square, T(least_tilt)));
    }
    Vec3<T> point() const { return (ring / s) * along - crown * n; }
    /// By a change of N, the wheel's axis kept.
    Vec3<T> by_normal(const Vec3<T>& change) const {
      const Vec3<T> dn = (change - n * n.dot(change)) / size;
      const T dz = dn.dot(e);
      return (ring / s) * (dz * e - dn + (z * dz / (s * s)) * along) - crown * dn;
    }
    /// By a change of the wheel's axis, N kept.
    Vec3<T> by_axis(const Vec3<T>& change) const {
      const T dz = n.dot(change);
      return (ring / s) * (dz * e + z * change + (z * dz / (s * s)) * along);
    }
  };

  /// The contact is where the wheel and the road have parallel tangent planes, one above the other: at (x, y)
  /// with (x, y) = d + ρ(N(x, y)) of the horizontal components, d the wheel's centre. Its rate follows from
  /// that. Where the wheel touches twice, or the search for the contact comes to no end, nothing is a number.
  /// Equations, with v = u + ω × ρ the velocity of the wheel's material there:
  ///
  ///     vx = vy = 0,  v̇ = u̇ + ω̇ × ρ + ω × ρ̇
  ///     Φ = (d + ρ) · z − h(x, y),  Φ̇ = N · v,  Φ̈ = N · v̇ + Ṅ · v
  ///
  /// where Φ̇ is exact, gap or not, as ρ moves along the rim's tangent plane when N does.
  template <class T>
  static void equations(const EquationContext<T>& c, ScalarEquation<T>* out) {
    const RelativeMotion<T>& r = c.motion;
    Vec3<T> origin;
    Mat3<T> A;
    for (int k = 0; k < 3; ++k) origin[k] = T(c.data.numbers[static_cast<std::size_t>(position + k)]);
    for (int k = 0; k < 9; ++k) A(k) = T(c.data.numbers[static_cast<std::size_t>(axes + k)]);
    const Vec3<T> d = origin + A * r.displacement, u = A * r.velocity, w = A * r.omega,
                  e = A * Vec3<T>(r.rotation.col(2));
    const T crown = c.number(1), ring = c.number(0) - crown;
    // From the contact with level ground on.
    const Vec3<T> level = d + Rim<T>(ring, crown, e, Vec3<T>::Unit(2)).point();
    T x = level[0], y = level[1];
    Ground<T> ground = ground_at(*c.road, x, y);
    // Of (x, y) by that of d + ρ, and whether that is unique: where the road bends more than the wheel, this
    // touches it twice.
    const auto change = [&](const Rim<T>& rim, const T& bx, const T& by, const auto& otherwise) {
      const Vec3<T> px = rim.by_normal(ground.by_x), py = rim.by_normal(ground.by_y);
      const T xx = T(1) - px[0], yy = T(1) - py[1], determinant = xx * yy - px[1] * py[0];
      const auto unique = determinant > T(0) && xx + yy > T(0);
      const T divisor = select(unique, determinant, T(1));
      return std::pair<T, T>(select(unique, T((yy * bx + py[0] * by) / divisor), otherwise(bx)),
                             select(unique, T((px[1] * bx + xx * by) / divisor), otherwise(by)));
    };
    for (int k = 0; k < most_iterations; ++k) {
      const Rim<T> rim(ring, crown, e, ground.normal);
      const Vec3<T> off = d + rim.point();
      const auto [dx, dy] = change(rim, T(off[0] - x), T(off[1] - y), [](const T& step) { return step; });
      x += dx;
      y += dy;
      ground = ground_at(*c.road, x, y);
      if (all(dx * dx + dy * dy <= T(least_step) * c.number(0) * c.number(0))) break;
    }
    const Rim<T> rim(ring, crown, e, ground.normal);
    const T none(std::numeric_limits<double>::quiet_NaN());
    const Vec3<T> off = d + rim.point() - Vec3<T>(x, y, ground.height);
    const auto found = off[0] * off[0] + off[1] * off[1] < T(most_off) * c.number(0) * c.number(0);
    const Vec3<T> place = rim.point(), v = u + w.cross(place), turned = rim.by_axis(w.cross(e));
    const auto [x1, y1] =
        change(rim, T(u[0] + turned[0]), T(u[1] + turned[1]), [&](const T&) { return none; });
    const Vec3<T> normal1 = ground.by_x * x1 + ground.by_y * y1;
    const Vec3<T> bias = w.cross(Vec3<T>(turned + rim.by_normal(normal1)));
    const auto set = [&](ScalarEquation<T>& equation, const Vec3<T>& direction, const T& more) {
      equation.linear = A.transpose() * direction;
      equation.angular = A.transpose() * place.cross(direction);
      equation.bias = direction.dot(bias) + more;
    };
    for (int k = 0; k < 2; ++k) {
      set(out[k], Vec3<T>::Unit(k), T(0));
      out[k].value = T(c.rate_time) * v[k];
    }
    set(out[2], ground.normal, normal1.dot(v));
    out[2].value = select(found, T(off[2] + T(0) * x1), none);
  }

 private:
  static constexpr int most_iterations = 8;    ///< Newton's, from level ground
  static constexpr double least_step = 1e-30;  ///< of them, by the radius, squared
  static constexpr double most_off = 1e-16;    ///< of the contact, by the radius, squared
  static constexpr double least_tilt = 1e-24;  ///< of s²
};

}  // namespace mimbre::constraints
