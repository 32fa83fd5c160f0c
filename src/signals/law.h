#pragma once
#include "forces/table.h"
#include "signals/sensors.h"

namespace mimbre {

template <class T>
LawContext<T> law_context(const Compiled& m, const ElementData& e, const SignalValues<T>& s) {
  return {m,
          e,
          s.time,
          s.value.data(),
          s.states + e.states,
          s.step,
          s.numbers,
          s.holds,
          s.moves ? s.rate.data() : nullptr};
}

/// Force and tangents of an element where it measures what its state has, with those of a feedback of its
/// own motion and the force of its inertia. A sum's force is shared among its legs, which have no law.
/// `storage`: of all elements' states; `feedback_of(e)`: as feedback() gives it.
template <class T, class Feedback>
void evaluate_law(const Compiled& m, const ElementData& e, SignalValues<T>& signals, T* storage,
                  const Feedback& feedback_of) {
  if (e.leg) return;
  ElementState<T> s = element_state(e, storage);
  forces::rows<T>[static_cast<std::size_t>(e.law)].law(law_context(m, e, signals), s);
  if (e.inertia >= 0) s.force[0] += signals.numbers[e.inertia] * *s.acceleration;
  if (e.feedback >= 0) {
    const auto [by_x, by_v] = feedback_of(e);
    s.stiffness[0] -= by_x;
    s.damping[0] -= by_v;
  }
  for (const Leg& leg : e.legs) {
    ElementState<T> share = element_state(m.elements[leg.element], storage);
    share.force[0] = leg.factor * s.force[0];
    share.stiffness[0] = share.damping[0] = T(0);
  }
}

template <class T>
void evaluate_law(const Compiled& m, const ElementData& e, SignalValues<T>& signals, T* storage) {
  evaluate_law(m, e, signals, storage, [&](const ElementData& of) { return feedback(m, of, signals); });
}

}  // namespace mimbre
