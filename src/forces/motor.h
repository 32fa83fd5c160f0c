#pragma once
#include <cmath>

#include "compile/slow_speeds.h"
#include "forces/element.h"

/// A motor with its gear on a joint's coordinate. It turns `ratio` times as fast as the joint, ω = n q̇, and
/// its torque τ(ω) comes from a curve times a command from −1 to 1, or from a voltage U by the constants of a
/// DC motor, τ = K i with R i = U − K ω. The gear passes on n (τ − losses); the rotor's inertia J adds n² J
/// to the mass matrix (ElementData::inertia): exact for a rotor that turns with the joint alone, without its
/// gyroscopic moment where its housing turns about another axis.
namespace mimbre::forces {

namespace motor {
/// Among the law's numbers.
constexpr int ratio = 0, constant = 2, resistance = 3, current_limit = 4, torque_limit = 5, drag = 6,
              efficiency = 7;
/// Behind those given: friction of the gear turns about within this speed of the motor, rad/s.
constexpr int slow = 8;

/// At the motor's side; slopes by its speed.
template <class T>
struct Torque {
  T made, slope, lost, lost_slope;
};

template <class T>
void limit(const T& most, T& value, T& slope) {
  const auto above = value > most, below = value < -most;
  slope = select(above, T(0), select(below, T(0), slope));
  value = select(above, most, select(below, T(-most), value));
}

template <class T>
Torque<T> torque(const LawContext<T>& c, const T& speed) {
  using std::abs, std::sqrt;
  const T* p = c.numbers();
  const T none(0), command = c.argument(0);
  Torque<T> t;
  if (c.element.functions >= 0) {
    // What turns against its command is held with the torque at rest.
    T share = command, unused(0);
    limit(T(1), share, unused);
    const T side = select(share < none, T(-1), T(1)), along = side * speed;
    const auto driven = along > none;
    const auto [most, slope] = tangent_at(c.function(0), select(driven, along, none));
    t.made = share * most;
    t.slope = select(driven, T(side * share * slope), none);
  } else {
    T current = (command - p[constant] * speed) / p[resistance], slope = -p[constant] / p[resistance];
    limit(p[current_limit], current, slope);
    t.made = p[constant] * current;
    t.slope = p[constant] * slope;
  }
  limit(p[torque_limit], t.made, t.slope);
  const T small = p[slow] * p[slow], size = sqrt(T(speed * speed + small)), turns = speed / size,
          kept = p[efficiency], share = T(1) - kept;
  t.lost = p[drag] * speed + share * abs(t.made) * turns;
  t.lost_slope = p[drag] + share * (abs(t.made) * small / (size * size * size) +
                                    select(t.made < none, T(-1), T(1)) * t.slope * turns);
  return t;
}
}  // namespace motor

template <class T>
void motor_law(const LawContext<T>& c, ElementState<T>& s) {
  const T n = c.numbers()[motor::ratio];
  const motor::Torque<T> t = motor::torque(c, T(n * s.v[0]));
  s.force[0] = n * (t.lost - t.made);
  s.stiffness[0] = T(0);
  s.damping[0] = n * n * (t.lost_slope - t.slope);
}

/// It works as a load does; what drag and gear take is lost.
inline void motor_energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
  const double n = c.numbers()[motor::ratio];
  const motor::Torque<double> t = motor::torque(c, n * s.v[0]);
  e.working[0] = -n * t.made;
  e.dissipating[0] = n * t.lost;
}

/// By `constant` and `resistance`, or by a function, its curve.
struct Motor {
  static constexpr std::array<LawNumber, 8> numbers{{
      {.key = "ratio",
       .unit = "rad/m|",
       .about = "of the motor's turns to the joint's coordinate",
       .otherwise = 1},
      {.key = "inertia", .unit = "kg m^2", .about = "of the rotor", .otherwise = 0, .least = 0},
      {.key = "constant",
       .unit = "N m/A",
       .about = "torque over current, and voltage over speed",
       .otherwise = 0,
       .least = 0},
      {.key = "resistance", .unit = "ohm", .about = "of the winding", .otherwise = 0, .least = 0},
      {.key = "current_limit", .unit = "A", .about = "of either sign", .otherwise = 1e300, .above = 0},
      {.key = "torque_limit",
       .unit = "N m",
       .about = "at the motor, of either sign",
       .otherwise = 1e300,
       .above = 0},
      {.key = "drag", .unit = "N m s/rad", .about = "viscous, at the motor", .otherwise = 0, .least = 0},
      {.key = "efficiency",
       .about = "of the gear, which takes the rest of the torque as friction",
       .otherwise = 1,
       .above = 0,
       .most = 1},
  }};
  static constexpr std::string_view fault(std::span<const double> n) {
    if (n[0] == 0) return "has the ratio 0, by which it would move nothing";
    return (n[2] > 0) == (n[3] > 0) ? "" : "'constant' and 'resistance' go together";
  }
  static void check(const spec::Element& e, std::vector<std::string>& faults) {
    if (e.numbers.size() == numbers.size() && e.functions.empty() != (e.numbers[motor::constant] > 0))
      faults.emplace_back("has a curve, or a constant and a resistance: one of both is needed");
  }
  /// motor::slow.
  static void derived(std::span<const double>, double, std::vector<double>& behind) { behind.push_back(0); }
  /// Of the rotor, as the joint's coordinate feels it, kg m² or kg.
  static double inertia(std::span<const double> n) { return n[0] * n[0] * n[1]; }
  /// At the joint. Without gravity: as fast as the motor turns the mechanism while its largest torque moves
  /// the joint by 1, or, of a DC motor that this torque is not known of, in the time in which K²/R brakes it.
  static double slow_gear(const Compiled& m, const ElementData& e, const double* p) {
    const MeasureScale scale = measure_scale(m, e);
    if (const double pace = pace_of_gravity(m); pace > 0) return slow_share * scale.size * pace;
    const double n = std::abs(p[motor::ratio]), constant = p[motor::constant];
    const bool by_curve = e.functions >= 0;
    const double stalled =
        by_curve ? std::abs(value_at(m.functions[e.functions], 0.0)) : constant * p[motor::current_limit];
    double pace =
        std::sqrt(n * std::min(stalled, p[motor::torque_limit]) * scale.size / scale.inertia) / scale.size;
    if (!by_curve) pace = std::min(pace, n * n * constant * constant / p[motor::resistance] / scale.inertia);
    return slow_share * scale.size * (pace > 0 ? pace : 1);
  }
  static void set_scales(const Compiled& m, const ElementData& e, double* p) {
    p[motor::slow] = std::abs(p[motor::ratio]) * slow_gear(m, e, p);
  }
  static constexpr LawInfo info{.name = "motor",
                                .section = "motors",
                                .coordinate = true,
                                .numbers = numbers,
                                .arguments = 1,
                                .functions = 1,
                                .fault = fault,
                                .check = check,
                                .derived = derived,
                                .inertia = inertia,
                                .set_scales = set_scales};

  template <class T>
  static void law(const LawContext<T>& c, ElementState<T>& s) {
    motor_law(c, s);
  }
  static void energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
    motor_energy(c, s, e);
  }
};

}  // namespace mimbre::forces
