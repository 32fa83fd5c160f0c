#pragma once
#include "model/compiled.h"

namespace mimbre {

/// Length, rate, tension (positive pulls the ends together) and its tangents of a translational
/// spring–damper; r, v: position and velocity of end b relative to end a, global axes (Lugrís
/// 2008, 2.110–2.119).
template <class T, class State>
void spring_state(const SpringData& s, const Vec3<T>& r, const Vec3<T>& v, double time, State& state) {
  state.length = r.norm();
  state.direction = r / state.length;
  state.rate = state.direction.dot(v);
  state.tension = s.elastic.value(state.length) + s.damping.value(state.rate);
  state.stiffness = s.elastic.derivative(state.length);
  state.damping = s.damping.derivative(state.rate);
  if (!s.general.is_zero()) {
    state.tension += s.general.value(state.length, state.rate, time);
    const auto [k, c] = s.general.derivatives(state.length, state.rate, time);
    state.stiffness += k;
    state.damping += c;
  }
}

}  // namespace mimbre
