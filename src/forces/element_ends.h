#pragma once
#include "forces/element.h"
#include "math/lanes.h"

namespace mimbre {

/// What an element is between, at the start of the step: of a pooled contact what its states name.
struct ElementEnds {
  int frame_a = -1;             ///< -1: the ground
  int frame_b = -1;             ///< -1: it is a place of a swarm that no pair has
  int surface = -1;             ///< contact: in a
  double radius = 0;            ///< contact: of the sphere about b
  int first = -1, second = -1;  ///< spheres of the swarm about a and b
};

/// `states`: the element's. Lanes have their pairs in common, those of the first.
template <class T>
ElementEnds ends_of(const Compiled& m, const ElementData& e, const T* states) {
  if (!e.pooled) return {e.frame_a, e.frame_b, e.surface, e.radius};
  const T* pair = states + law_states(e);
  const int a = static_cast<int>(in_lane(pair[0], 0)) - 1, b = static_cast<int>(in_lane(pair[1], 0)) - 1;
  if (a < 0 || b < 0) return {};
  const SwarmSphere &on = m.swarms[e.spec].spheres[a], &by = m.swarms[e.spec].spheres[b];
  return {on.frame, by.frame, on.surface, by.radius, a, b};
}

/// The state of a place that no pair has: nothing touches there.
template <class T>
void leave_free(const ElementData& e, const ElementState<T>& s) {
  T* const end = s.states + e.state_count;
  for (T* x = s.x; x != end; ++x) *x = T(0);
}

}  // namespace mimbre
