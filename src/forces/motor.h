#pragma once
#include <cmath>

#include "forces/element.h"
#include "model/force_laws.h"

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
/// Friction of the gear turns about within this speed, rad/s.
constexpr int slow = motor_slow;

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

}  // namespace mimbre::forces
