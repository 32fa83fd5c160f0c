#pragma once
#include "forces/element.h"

/// A law that the user wrote.
namespace mimbre::forces {

namespace user {
constexpr int most_arguments = 64;

/// Calls it; `out`: 6 forces, 36 stiffnesses, 36 dampings, and shares that dissipate, all zero.
struct Answer {
  double force[6] = {}, stiffness[36] = {}, damping[36] = {}, dissipating[6] = {};
  double stored = 0;
};
inline Answer call(const LawContext<double>& c, const double* x, const double* v, double* next) {
  Answer answer;
  std::array<double, most_arguments> signals;
  for (int k = 0; k < c.element.argument_count; ++k) signals[k] = c.argument(k);
  const spec::UserLaw& law = *c.element.user;
  spec::LawCall call;
  call.time = c.time;
  call.step = c.step;
  call.components = c.element.count;
  call.x = x;
  call.v = v;
  call.signals = signals.data();
  call.states = c.states + c.element.own_states;
  call.force = answer.force;
  call.stiffness = answer.stiffness;
  call.damping = answer.damping;
  call.dissipating = answer.dissipating;
  call.next = next;
  for (std::size_t k = 0; k < law.states.size(); ++k) next[k] = call.states[k];
  law.evaluate(call);
  answer.stored = call.stored;
  return answer;
}
}  // namespace user

inline void user_law(const LawContext<double>& c, ElementState<double>& s) {
  const int n = s.count;
  if (c.element.user->sampled) {
    // Called before the step (signals/sampling.h), which keeps what it said.
    for (int k = 0; k < n; ++k) s.force[k] = c.states[c.element.own_states + k];
    for (int k = 0; k < n * n; ++k) s.stiffness[k] = s.damping[k] = 0;
    for (int k = c.element.own_states; k < c.element.state_count; ++k) s.states[k] = c.states[k];
    return;
  }
  const user::Answer answer = user::call(c, s.x, s.v, s.states + c.element.own_states);
  for (int k = 0; k < n; ++k) s.force[k] = answer.force[k];
  for (int r = 0; r < n; ++r)
    for (int k = 0; k < n; ++k) {
      // The matrix of a step is symmetric.
      s.stiffness[r * n + k] = 0.5 * (answer.stiffness[r * n + k] + answer.stiffness[k * n + r]);
      s.damping[r * n + k] = 0.5 * (answer.damping[r * n + k] + answer.damping[k * n + r]);
    }
}

inline void user_energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
  const int n = s.count;
  if (c.element.user->sampled) {
    for (int k = 0; k < n; ++k) e.working[k] = s.force[k];
    return;
  }
  std::array<double, user::most_arguments> next;
  const user::Answer answer = user::call(c, s.x, s.v, next.data());
  e.stored = answer.stored;
  for (int k = 0; k < n; ++k) {
    e.dissipating[k] = answer.dissipating[k];
    if (!c.element.user->elastic) e.working[k] = answer.force[k] - answer.dissipating[k];
  }
}

}  // namespace mimbre::forces
