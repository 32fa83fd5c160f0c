#pragma once
#include <algorithm>

#include "math/rotation.h"
#include "model/compiled.h"

namespace mimbre {

/// Road height under a global x (or at a time).
inline double road_height(const RoadData& road, double x, double time) {
  return road.height.value(road.over == spec::Road::Over::distance ? x : time);
}

/// Vertical force of the benchmark's tyre at a wheel centre's global position: stiffness · penetration when
/// positive.
template <class T, class State>
void tyre_state(const TyreData& t, const RoadData& road, const Vec3<T>& centre, double time, State& state) {
  state.road = road_height(road, centre[0], time);
  state.penetration = t.radius - (centre[2] - state.road);
  const bool contact = state.penetration > T(0);
  state.force = contact ? t.stiffness * state.penetration : T(0);
  state.stiffness = contact ? T(t.stiffness) : T(0);
}

/// Its potential, J: of a wheel centre and a road at these heights.
inline double tyre_potential(const TyreData& t, double wheel, double road) {
  const double penetration = std::max(0.0, t.radius - (wheel - road));
  return 0.5 * t.stiffness * penetration * penetration;
}

}  // namespace mimbre
