#pragma once
#include <cmath>

#include "compile/slow_speeds.h"
#include "forces/element.h"
#include "forces/impact.h"
#include "math/restitution.h"

/// Stops at the ends of a travel: of a joint's coordinate, or of the distance of two points (bump stops).
/// Within its depth d a stop pushes back with f(d) (1 + c ḋ), f = k e/n (d/e)ⁿ (Hunt and Crossley, J. Appl.
/// Mech. 42, 1975), and never pulls. With c = a/v₀, v₀ the speed of the impact, a body alone leaves with
/// exactly the share `restitution` of v₀ (math/restitution.h).
namespace mimbre::forces {

namespace stop {
/// Among the law's numbers.
constexpr int lower = 0, upper = 1, stiffness = 2, exponent = 3, depth = 4, restitution = 5;
/// Behind those given: a, and the speed, m/s or rad/s, below which no impact counts.
constexpr int damping = 6, slow = 7;

/// `d`: depth, `speed`: at which it grows, `factor`: c.
template <class T>
impact::Push<T> push(const T* p, const T& d, const T& speed, const T& factor) {
  return impact::push(p[stiffness], p[exponent], p[depth], d, speed, factor);
}

template <class T>
T factor_of(const LawContext<T>& c) {
  const T speed = c.states[c.element.own_states];
  return impact::factor(c.numbers()[damping], speed, c.numbers()[slow]);
}
}  // namespace stop

template <class T>
void stop_law(const LawContext<T>& c, ElementState<T>& s) {
  using namespace stop;
  const T* p = c.numbers();
  const T x = s.x[0], v = s.v[0], below = p[lower] - x, above = x - p[upper], factor = factor_of(c);
  const impact::Push<T> up = push(p, below, T(-v), factor), down = push(p, above, v, factor);
  s.force[0] = down.force - up.force;
  s.stiffness[0] = down.along_depth + up.along_depth;
  s.damping[0] = down.along_speed + up.along_speed;
  // The speed of the next impact, as long as there is none.
  using std::abs;
  const auto touches = select(below > above, below, above) > T(0);
  s.states[c.element.own_states] = select(touches, c.states[c.element.own_states], T(abs(v)));
}

inline void stop_energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
  using namespace stop;
  const double* p = c.numbers();
  const double factor = factor_of(c);
  for (const double side : {-1.0, 1.0}) {
    const double d = side < 0 ? p[lower] - s.x[0] : s.x[0] - p[upper];
    if (d <= 0) continue;
    const impact::Push<double> made = push(p, d, side * s.v[0], factor);
    e.stored += made.elastic * d / (p[exponent] + 1);
    e.dissipating[0] += side * (made.force - made.elastic);
  }
}

/// ±1e300: no end there.
struct Stop {
  static constexpr std::array<LawNumber, 6> numbers{{
      {.key = "lower", .unit = "m|rad", .about = "where it begins below", .otherwise = -1e300},
      {.key = "upper", .unit = "m|rad", .about = "where it begins above", .otherwise = 1e300},
      {.key = "stiffness",
       .unit = "N/m|N m/rad",
       .about = "at 'depth', or anywhere where the exponent is 1",
       .above = 0},
      {.key = "exponent", .about = "of the force over the depth; 1: linear", .otherwise = 1, .least = 1},
      {.key = "depth",
       .unit = "m|rad",
       .about = "at which the stiffness is that",
       .otherwise = by_scales,
       .above = 0},
      {.key = "restitution",
       .about = "coefficient of restitution: ratio of rebound to impact speed",
       .otherwise = 1,
       .least = 0.01,
       .most = 1},
  }};
  static constexpr std::string_view fault(std::span<const double> n) {
    if (n[0] <= -1e300 && n[1] >= 1e300) return "gives no end of the travel: 'lower' or 'upper' is needed";
    return n[0] < n[1] ? "" : "'lower' has to be below 'upper'";
  }
  /// The damping that the restitution needs, and stop::slow.
  static void derived(std::span<const double> n, double, std::vector<double>& behind) {
    behind.insert(behind.end(), {restitution_damping(n[stop::restitution]), 0});
  }
  static void set_scales(const Compiled& m, const ElementData& e, double* p) {
    set_usual_depth(m, e, p[stop::depth]);
    p[stop::slow] = slow_impact(m, e, p[stop::stiffness], p[stop::exponent], p[stop::depth]);
  }
  static constexpr LawInfo info{.name = "stop",
                                .section = "stops",
                                .along = true,
                                .coordinate = true,
                                .numbers = numbers,
                                .states = 1,
                                .fault = fault,
                                .derived = derived,
                                .set_scales = set_scales,
                                .drawn_along = "damper",
                                .drawn_at_joint = "stop"};

  template <class T>
  static void law(const LawContext<T>& c, ElementState<T>& s) {
    stop_law(c, s);
  }
  static void energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
    stop_energy(c, s, e);
  }
};

}  // namespace mimbre::forces
