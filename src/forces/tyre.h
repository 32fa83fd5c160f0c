#pragma once
#include <algorithm>

#include "forces/element.h"

/// The benchmark's tyre: stiffness times penetration where there is contact, upwards on the wheel's centre.
namespace mimbre::forces {

namespace tyre {
constexpr int stiffness = 0, radius = 1;  ///< among the law's numbers
}

/// x: height of the wheel's centre above the road.
inline void tyre_law(const LawContext<double>& c, ElementState<double>& s) {
  const double penetration = c.numbers()[tyre::radius] - s.x[0];
  const bool contact = penetration > 0;
  s.force[0] = contact ? -c.numbers()[tyre::stiffness] * penetration : 0;
  s.stiffness[0] = contact ? c.numbers()[tyre::stiffness] : 0;
  s.damping[0] = 0;
}

inline void tyre_energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
  const double penetration = std::max(0.0, c.numbers()[tyre::radius] - s.x[0]);
  e.stored = 0.5 * c.numbers()[tyre::stiffness] * penetration * penetration;
}

}  // namespace mimbre::forces
