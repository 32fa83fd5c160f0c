#pragma once
#include <fmt/format.h>

#include "constraints/equation_context.h"
#include "math/choice.h"

namespace mimbre::constraints {

/// b, a wheel about its z axis, rolls without slip on the plane through a's origin at right angles to a's z.
/// The wheel is a torus: circles of the radius `crown` about a ring. A crown of 0 is a sharp disc, one of the
/// whole radius a ball.
struct Rolling {
  static constexpr std::array<LawNumber, 2> numbers{
      {{.key = "radius", .unit = "m", .about = "of the wheel, from its centre to its rim", .above = 0},
       {.key = "crown",
        .unit = "m",
        .about = "radius of the rim across the wheel; 0: a sharp disc; the radius itself: a ball",
        .otherwise = 0,
        .least = 0}}};
  static void check(const spec::Constraint& c, ConstraintInfo::Faults& faults) {
    if (c.numbers[1] > c.numbers[0])
      faults.push_back(
          fmt::format("crown is {} m and radius {} m; a ball has both alike, a wheel a smaller "
                      "crown",
                      c.numbers[1], c.numbers[0]));
  }
  static constexpr ConstraintInfo info{.name = "rolling",
                                       .equations = 3,
                                       .lengths = 0b111,
                                       .rates = 0b011,
                                       .force = true,
                                       .moment = true,
                                       .numbers = numbers,
                                       .axes = 2,
                                       .two_places = true,
                                       .check = check};

  /// With the plane's normal n, the wheel's axis e, s = |n × e| and the ring's radius R, the contact point is
  /// at ρ = R (z e − n)/s − crown n from the centre, z = n · e. Its material velocity u + ω × ρ vanishes; the
  /// component along n is the rate of the height d · n − R s − crown. A wheel that lies flat touches
  /// everywhere.
  template <class T>
  static void equations(const EquationContext<T>& c, ScalarEquation<T>* out) {
    using std::sqrt;
    const RelativeMotion<T>& r = c.motion;
    const T crown = c.number(1), ring = c.number(0) - crown;
    const Vec3<T> n = Vec3<T>::Unit(2), e = r.rotation.col(2), e1 = r.omega.cross(e);
    const T square = e[0] * e[0] + e[1] * e[1];
    const T s = sqrt(select(square > T(least_tilt), square, T(least_tilt)));
    const T s1 = (e[0] * e1[0] + e[1] * e1[1]) / s;
    const Vec3<T> down = e[2] * e - n, down1 = e1[2] * e + e[2] * e1;
    const Vec3<T> place = (ring / s) * down - crown * n;
    const Vec3<T> place1 = (ring / s) * (down1 - (s1 / s) * down);
    const Vec3<T> bias = r.omega.cross(place1);
    for (int k = 0; k < 3; ++k) {
      out[k].linear = Vec3<T>::Unit(k);
      out[k].angular = place.cross(out[k].linear);
      out[k].bias = bias[k];
    }
    for (int k = 0; k < 2; ++k) out[k].value = T(c.rate_time) * out[k].rate(r);
    out[2].value = r.displacement[2] - ring * s - crown;
  }

 private:
  static constexpr double least_tilt = 1e-24;  ///< of s²
};

}  // namespace mimbre::constraints
