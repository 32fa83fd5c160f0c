#pragma once
#include <limits>
#include <vector>

#include "forces/element.h"

/// A law that the user wrote.
namespace mimbre::forces {

namespace user {
constexpr int most_arguments = 64;

/// Calls it with its states.
struct Answer {
  double force[6] = {}, stiffness[36] = {}, damping[36] = {}, dissipating[6] = {};
  double stored = 0;
};
inline Answer call(const LawContext<double>& c, const double* x, const double* v, const double* states,
                   double* next) {
  Answer answer;
  std::array<double, most_arguments> signals;
  for (int k = 0; k < c.element.argument_count; ++k) signals[k] = c.argument(k);
  const spec::UserLaw& law = c.user();
  spec::LawCall call;
  call.time = c.time;
  call.step = c.step;
  call.components = c.element.count;
  call.x = x;
  call.v = v;
  call.signals = signals.data();
  call.states = states;
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

/// What a law that is called before the step (simulation/step/signal_state.cpp) said: that is kept.
template <class T>
void sampled_law(const LawContext<T>& c, ElementState<T>& s) {
  const int n = s.count;
  for (int k = 0; k < n; ++k) s.force[k] = c.states[c.element.own_states + k];
  for (int k = 0; k < n * n; ++k) s.stiffness[k] = s.damping[k] = T(0);
  for (int k = c.element.own_states; k < c.element.state_count; ++k) s.states[k] = c.states[k];
}

inline void user_law(const LawContext<double>& c, ElementState<double>& s) {
  const int n = s.count;
  if (c.element.sampled) return sampled_law(c, s);
  const user::Answer answer =
      user::call(c, s.x, s.v, c.states + c.element.own_states, s.states + c.element.own_states);
  for (int k = 0; k < n; ++k) s.force[k] = answer.force[k];
  for (int r = 0; r < n; ++r)
    for (int k = 0; k < n; ++k) {
      // The matrix of a step is symmetric.
      s.stiffness[r * n + k] = 0.5 * (answer.stiffness[r * n + k] + answer.stiffness[k * n + r]);
      s.damping[r * n + k] = 0.5 * (answer.damping[r * n + k] + answer.damping[k * n + r]);
    }
}

/// Users write laws for numbers: the values of other scalars are put into one lane, or one value with its
/// direction, after the other, so it costs as much. Not for the step, as this allocates.
///
/// Of dual numbers the law says how its force varies with what it measures. What it does not say, how it
/// varies with signals and states and these with anything, is not a number where it matters.
template <class T>
void user_law(const LawContext<T>& c, ElementState<T>& s) {
  if (c.element.sampled) return sampled_law(c, s);
  const int n = s.count, states = c.element.state_count;
  const std::size_t slots = static_cast<std::size_t>(c.model.signals.slots);
  std::vector<double> storage(static_cast<std::size_t>(element_storage(c.element))), signals(slots),
      before(static_cast<std::size_t>(states));
  ElementState<double> one = element_state_at(c.element, storage.data());
  const auto run = [&](const auto& part) {
    for (std::size_t k = 0; k < slots; ++k) signals[k] = part(c.signals[k]);
    for (int k = 0; k < states; ++k) before[static_cast<std::size_t>(k)] = part(c.states[k]);
    for (int k = 0; k < n; ++k) {
      one.x[k] = part(s.x[k]);
      one.v[k] = part(s.v[k]);
    }
    user_law(LawContext<double>{c.model, c.element, c.time, signals.data(), before.data(), c.step}, one);
  };
  const int first = c.element.own_states;
  if constexpr (is_pack<T>) {
    for (int i = 0; i < T::lanes; ++i) {
      run([&](const T& x) { return x[i]; });
      for (int k = 0; k < n; ++k) s.force[k][i] = one.force[k];
      for (int k = 0; k < n * n; ++k) {
        s.stiffness[k][i] = one.stiffness[k];
        s.damping[k][i] = one.damping[k];
      }
      for (int k = first; k < states; ++k) s.states[k][i] = one.states[k];
    }
  } else {
    run([](const T& x) { return x.value; });
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    bool varies = false, held = true;
    for (int k = 0; k < c.element.argument_count; ++k) held = held && c.argument(k).derivative == 0;
    for (int k = first; k < states; ++k) held = held && c.states[k].derivative == 0;
    for (int k = 0; k < n; ++k) varies = varies || s.x[k].derivative != 0 || s.v[k].derivative != 0;
    for (int r = 0; r < n; ++r) {
      double by = held ? 0 : unknown;
      for (int k = 0; k < n; ++k)
        by += one.stiffness[r * n + k] * s.x[k].derivative + one.damping[r * n + k] * s.v[k].derivative;
      s.force[r] = T(one.force[r], by);
    }
    const double others = varies || !held ? unknown : 0;
    for (int k = 0; k < n * n; ++k) {
      s.stiffness[k] = T(one.stiffness[k], others);
      s.damping[k] = T(one.damping[k], others);
    }
    for (int k = first; k < states; ++k) s.states[k] = T(one.states[k], others);
  }
}

inline void user_energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
  const int n = s.count;
  if (c.element.sampled) {
    for (int k = 0; k < n; ++k) e.working[k] = s.force[k];
    return;
  }
  std::array<double, user::most_arguments> next;
  const user::Answer answer = user::call(c, s.x, s.v, c.states + c.element.own_states, next.data());
  e.stored = answer.stored;
  for (int k = 0; k < n; ++k) {
    e.dissipating[k] = answer.dissipating[k];
    if (!c.element.elastic) e.working[k] = answer.force[k] - answer.dissipating[k];
  }
}

struct User {
  static constexpr LawInfo info{
      .name = "user", .along = true, .coordinate = true, .axis = true, .relative = true};

  template <class T>
  static void law(const LawContext<T>& c, ElementState<T>& s) {
    user_law(c, s);
  }
  static void energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
    user_energy(c, s, e);
  }
};

}  // namespace mimbre::forces
