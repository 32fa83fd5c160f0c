#pragma once
#include "model/compiled.h"

namespace mimbre {

/// Spring and damper on a joint coordinate: `force` resists it.
template <class T>
struct JointSpringState {
  T force, stiffness, damping;
};

template <class T>
JointSpringState<T> joint_spring_state(const JointSpringData& s, const T& x, const T& rate) {
  return {s.elastic.value(x) + s.damping.value(rate), s.elastic.derivative(x), s.damping.derivative(rate)};
}

/// Potential of the elastic law, J, and the damper's force, which dissipates.
inline double joint_spring_potential(const JointSpringData& s, double x) {
  return s.elastic.antiderivative(x);
}
inline double joint_spring_damping(const JointSpringData& s, double rate) { return s.damping.value(rate); }

}  // namespace mimbre
