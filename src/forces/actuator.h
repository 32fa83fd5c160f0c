#pragma once
#include "forces/element.h"

/// A force, or a torque, that a signal sets: in the direction in which the measure grows.
namespace mimbre::forces {

/// The tangents of a feedback of its own motion are added by what knows the signals (signals/sensors.h).
template <class T>
void actuator_law(const LawContext<T>& c, ElementState<T>& s) {
  s.force[0] = -c.argument(0);
  s.stiffness[0] = s.damping[0] = T(0);
}

inline void actuator_energy(const LawContext<double>&, const ElementState<double>& s, ElementEnergy& e) {
  e.working[0] = s.force[0];
}

struct Actuator {
  static constexpr LawInfo info{.name = "actuator",
                                .section = "actuators",
                                .along = true,
                                .coordinate = true,
                                .axis = true,
                                .arguments = 1,
                                .given = true};

  template <class T>
  static void law(const LawContext<T>& c, ElementState<T>& s) {
    actuator_law(c, s);
  }
  static void energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
    actuator_energy(c, s, e);
  }
};

}  // namespace mimbre::forces
