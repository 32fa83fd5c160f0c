#pragma once
#include "forces/element.h"

/// A force, or a torque, that a signal says: in the direction in which the measure grows.
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

}  // namespace mimbre::forces
