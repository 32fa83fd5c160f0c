#pragma once
#include <cmath>

#include "compile/slow_speeds.h"
#include "forces/carcass.h"
#include "forces/element.h"
#include "forces/measure_wheel.h"
#include "math/smooth.h"

/// A tyre: a spring with a damper in the vertical direction, and a brush behind a carcass along and across
/// (forces/carcass.h). The force across acts behind the middle of the footprint, by the trail of the brush.
/// The tangents leave out what the forces along the road owe to the vertical one: that is not symmetric.
namespace mimbre::forces {

namespace brush_tyre {
/// Among the law's numbers.
constexpr int stiffness = 0, radius = 1, damping = 2, slip_stiffness = 3 /* along, across */, friction = 5,
              relaxation = 6 /* likewise */, half_length = 8, load = 9, resistance = 10, settling = 11;
/// Behind those given: the speed at which it hardly rolls, m/s.
constexpr int slow = 12;
/// Among the states.
constexpr int bend = wheel::bend;

/// Push of the spring and of all, upwards, N, with the tangents of that.
template <class T>
struct Vertical {
  T spring, force, stiffness, damping;
};

template <class T>
Vertical<T> vertical(const T& spring, const T& damper, const T& gap, const T& rate) {
  Vertical<T> push;
  push.spring = select(gap < T(0), T(T(-1) * spring * gap), T(0));
  const T all = push.spring - damper * rate;
  // The damper does not hold the wheel down.
  const auto presses = gap < T(0) && all > T(0);
  push.force = select(presses, all, T(0));
  push.stiffness = select(presses, spring, T(0));
  push.damping = select(presses, damper, T(0));
  return push;
}

template <class T>
T carcass_stiffness(const T* p, int k) {
  return p[slip_stiffness + k] / p[relaxation + k];
}
}  // namespace brush_tyre

template <class T>
void brush_tyre_law(const LawContext<T>& c, ElementState<T>& s) {
  using namespace brush_tyre;
  using std::abs, std::sqrt;
  const int n = s.count;
  const T* p = c.numbers();
  for (int k = 0; k < n; ++k) s.force[k] = T(0);
  for (int k = 0; k < n * n; ++k) s.stiffness[k] = s.damping[k] = T(0);
  const Vertical<T> push = vertical<T>(p[stiffness], p[damping], s.x[wheel::gap], s.v[wheel::gap]);
  s.force[wheel::gap] = T(-1) * push.force;
  s.stiffness[0] = push.stiffness;
  s.damping[0] = push.damping;

  // At a load of its own, slip stiffnesses and the square of the footprint's length go with the load.
  const auto varies = p[load] > T(0);
  const T ratio = select(varies, T(push.force / select(varies, p[load], T(1))), T(1));
  const T rolling = wheel::rolling_speed(c.element, s);
  wheel::set_stood(c.element, p[slow], s);
  carcass::Wheel<T> w;
  for (int k = 0; k < 2; ++k) {
    w.spring[k] = carcass_stiffness(p, k);
    w.stiffness[k] = p[slip_stiffness + k] * (ratio + T(1e-6));
  }
  w.settling = p[settling];
  w.rolled = abs(rolling);
  w.limit = push.force * p[friction] * s.surroundings[wheel::friction];
  w.bend = c.states + bend;
  w.rate = s.v + wheel::forth;
  if (c.step <= 0) w.gone = wheel::gone(c.element, c.states, s);
  const carcass::Followed<T> footprint = carcass::follow(w, c.step);
  const carcass::FootprintForce<T>& shear = footprint.shear;
  for (int k = 0; k < 2; ++k) {
    s.force[wheel::forth + k] = shear.force[k];
    s.states[bend + k] = footprint.bend[k];
  }
  carcass::put_tangents(footprint, wheel::forth, s);

  // Slower than `slow`, rolling one way or the other is more and more the same.
  const T forwards = smooth::direction(rolling, p[slow]);
  const T lever = push.force * p[resistance] * p[radius];
  s.force[wheel::rolling] = lever * forwards;
  s.damping[wheel::rolling * (n + 1)] = lever * p[radius] * smooth::direction_slope(rolling, p[slow]);
  const T left = T(1) - shear.used, length = p[half_length] * sqrt(ratio + T(1e-12));
  const T trail = length / T(3) * left * left * left / (left + shear.used * shear.used / T(3));
  s.force[wheel::aligning] = T(-1) * trail * forwards * shear.force[1];
}

/// The vertical spring and the carcass store; all that the forces along the road do beyond is lost.
inline void brush_tyre_energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
  using namespace brush_tyre;
  const double* p = c.numbers();
  const double spring = vertical<double>(p[stiffness], 0, s.x[wheel::gap], 0).spring;
  e.stored = 0.5 * spring * spring / p[stiffness];
  for (int k = 0; k < 2; ++k) {
    const double carcass_spring = carcass_stiffness(p, k), was = c.states[bend + k], is = s.states[bend + k];
    e.stored += 0.5 * carcass_spring * is * is;
    if (c.step > 0) e.lost -= 0.5 * carcass_spring * (is * is - was * was);
  }
  e.dissipating[wheel::gap] = s.force[wheel::gap] + spring;
  for (int k = wheel::forth; k < s.count; ++k) e.dissipating[k] = s.force[k];
}

/// The usual acceleration a of a tyre of radius R, m/s²: that of gravity, or without it the one of the mean
/// mass on a tyre that is pressed in by R/20.
inline double usual_acceleration(const Compiled& m, const ElementData& e, double stiffness) {
  constexpr double usual_deflection = 0.05;
  const double gravity = m.gravity.norm();
  return gravity > 0 ? gravity : usual_deflection * e.radius * stiffness / m.mass_scale;
}

/// Speed at which a wheel hardly rolls, m/s: a share of the speed √(a R) that it reaches within R/2.
inline double slow_rolling(const Compiled& m, const ElementData& e, double stiffness) {
  constexpr double share = 0.1;
  return share * std::sqrt(usual_acceleration(m, e, stiffness) * e.radius);
}

/// Sets a settling time that is not given: a share of √(R/a), 0.02 s at 0.32 m.
inline void set_settling(const Compiled& m, const ElementData& e, double stiffness, double& settling) {
  constexpr double share = 0.11;
  if (!(settling < by_scales)) settling = share * std::sqrt(e.radius / usual_acceleration(m, e, stiffness));
}

/// The numbers stand behind the vertical stiffness and the radius.
struct BrushTyre {
  static constexpr std::array<LawNumber, 10> numbers{{
      {.key = "damping", .unit = "N s/m", .about = "vertical", .otherwise = 0, .least = 0},
      {.key = "longitudinal_stiffness", .unit = "N", .about = "force over slip, at small slip", .above = 0},
      {.key = "cornering_stiffness",
       .unit = "N/rad",
       .about = "force over slip angle, at small angles",
       .above = 0},
      {.key = "friction", .about = "limit of the force along the road, by the vertical one", .least = 0},
      {.key = "longitudinal_relaxation",
       .unit = "m",
       .about = "way on which the force along follows its slip",
       .above = 0},
      {.key = "lateral_relaxation",
       .unit = "m",
       .about = "way on which the force across follows its slip",
       .above = 0},
      {.key = "half_length", .unit = "m", .about = "of the footprint", .above = 0},
      {.key = "load",
       .unit = "N",
       .about = "at which these are so: stiffnesses go with the load; 0: they do not",
       .otherwise = 0,
       .least = 0},
      {.key = "rolling_resistance",
       .about = "force that resists rolling, by the vertical one",
       .otherwise = 0,
       .least = 0},
      {.key = "settling",
       .unit = "s",
       .about = "damping over stiffness of the carcass, of a wheel that stands",
       .otherwise = by_scales,
       .least = 0},
  }};
  /// That of a key, for laws that have it, too.
  static constexpr const LawNumber& number(std::string_view key) {
    std::size_t k = 0;
    while (numbers[k].key != key) ++k;
    return numbers[k];
  }
  /// brush_tyre::slow.
  static void derived(std::span<const double>, double, std::vector<double>& behind) { behind.push_back(0); }
  static void set_scales(const Compiled& m, const ElementData& e, double* p) {
    p[brush_tyre::slow] = slow_rolling(m, e, p[brush_tyre::stiffness]);
    set_settling(m, e, p[brush_tyre::stiffness], p[brush_tyre::settling]);
  }
  static double slow_speed(const double* p) { return p[brush_tyre::slow]; }
  /// It rolls as a wheel that is smaller by a third of its deflection.
  static RollingSize rolling_size(std::span<const double> n) {
    return {1. / 3, n[brush_tyre::half_length - 2]};
  }
  static constexpr LawInfo info{.name = "brush_tyre",
                                .list = SpecList::tyres,
                                .numbers = numbers,
                                .states = 9,
                                .derived = derived,
                                .set_scales = set_scales,
                                .model = "brush",
                                .slow_speed = slow_speed,
                                .rolling_size = rolling_size};

  template <class T>
  static void law(const LawContext<T>& c, ElementState<T>& s) {
    brush_tyre_law(c, s);
  }
  static void energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
    brush_tyre_energy(c, s, e);
  }
};

}  // namespace mimbre::forces
