#pragma once
#include "forces/element.h"

/// Measures, and exerts no force.
namespace mimbre::forces {

struct Sensor {
  static constexpr LawInfo info{.name = "sensor",
                                .list = SpecList::sensors,
                                .along = true,
                                .coordinate = true,
                                .axis = true,
                                .relative = true};
  template <class T>
  static void law(const LawContext<T>&, ElementState<T>& s) {
    for (int k = 0; k < s.count; ++k) s.force[k] = T(0);
    for (int k = 0; k < s.count * s.count; ++k) s.stiffness[k] = s.damping[k] = T(0);
  }
  static void energy(const LawContext<double>&, const ElementState<double>&, ElementEnergy&) {}
};

}  // namespace mimbre::forces
