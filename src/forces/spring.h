#pragma once
#include "math/rotation.h"
#include "model/compiled.h"

namespace mimbre {

/// Length, rate, tension (positive pulls the ends together) and its tangents of a translational
/// spring–damper; r, v: position and velocity of end b relative to end a, global axes (Lugrís
/// 2008, 2.110–2.119). Where the ends meet, the direction is that in which they part; without any, there is
/// no force.
template <class T, class State>
void spring_state(const SpringData& s, const Vec3<T>& r, const Vec3<T>& v, double time, State& state) {
  state.length = r.norm();
  const T speed = v.norm();
  state.direction = state.length > T(0) ? Vec3<T>(r / state.length)
                    : speed > T(0)      ? Vec3<T>(v / speed)
                                        : Vec3<T>(Vec3<T>::Zero());
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

/// Potential of the elastic law, J: zero at the assembled length.
inline double spring_potential(const SpringData& s, double length) {
  return s.elastic.antiderivative(length) - s.elastic.antiderivative(s.free_length);
}

/// The parts of the tension whose power is no potential's, N: of the damper, which dissipates, and of the
/// general law, whose work at rate 0 counts as a load's and the rest as a damper's.
inline double spring_damping(const SpringData& s, double rate) { return s.damping.value(rate); }
inline double spring_general(const SpringData& s, double length, double rate, double time) {
  return s.general.is_zero() ? 0 : s.general.value(length, rate, time);
}

}  // namespace mimbre
