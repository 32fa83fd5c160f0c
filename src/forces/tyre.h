#pragma once
#include <algorithm>

#include "forces/element.h"

/// The benchmark's tyre: stiffness times penetration where there is contact, upwards on the wheel's centre.
namespace mimbre::forces {

namespace tyre {
constexpr int stiffness = 0, radius = 1;  ///< among the law's numbers
}

/// x: height of the wheel's centre above the road.
template <class T>
void tyre_law(const LawContext<T>& c, ElementState<T>& s) {
  const T penetration = c.numbers()[tyre::radius] - s.x[0];
  const auto contact = penetration > T(0);
  s.force[0] = select(contact, T(-c.numbers()[tyre::stiffness] * penetration), T(0));
  s.stiffness[0] = select(contact, c.numbers()[tyre::stiffness], T(0));
  s.damping[0] = T(0);
}

inline void tyre_energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
  const double penetration = std::max(0.0, c.numbers()[tyre::radius] - s.x[0]);
  e.stored = 0.5 * c.numbers()[tyre::stiffness] * penetration * penetration;
}

struct Tyre {
  static constexpr LawInfo info{.name = "tyre", .list = SpecList::tyres, .model = "vertical"};

  template <class T>
  static void law(const LawContext<T>& c, ElementState<T>& s) {
    tyre_law(c, s);
  }
  static void energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
    tyre_energy(c, s, e);
  }
};

}  // namespace mimbre::forces
