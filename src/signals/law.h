#pragma once
#include "forces/table.h"
#include "signals/sensors.h"

namespace mimbre {

template <class T>
LawContext<T> law_context(const Compiled& m, const ElementData& e, const SignalValues<T>& s) {
  return {m, e, s.time, s.value.data(), s.states + e.states, s.step, s.numbers};
}

/// Force and tangents of an element where it measures what its state says, with those of a feedback of its
/// own motion.
template <class T>
void evaluate_law(const Compiled& m, const ElementData& e, SignalValues<T>& signals, ElementState<T>& s) {
  forces::rows<T>[static_cast<std::size_t>(e.law)].law(law_context(m, e, signals), s);
  if (e.feedback < 0) return;
  const auto [by_x, by_v] = feedback(m, e, e.feedback, signals);
  s.stiffness[0] -= by_x;
  s.damping[0] -= by_v;
}

}  // namespace mimbre
