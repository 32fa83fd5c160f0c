#pragma once
#include <array>
#include <limits>
#include <vector>

#include "math/function_values.h"
#include "model/compiled.h"

/// What a step sees of time, inputs and signals: one number per slot, with two derivatives by time of those
/// that time and inputs alone decide.
namespace mimbre {

template <class T>
struct SignalValues {
  /// Of other scalars than double what is held, the states and the numbers have to be set.
  explicit SignalValues(const Compiled& m)
      : value(m.signals.slots, T(std::numeric_limits<double>::quiet_NaN())),
        rate(m.signals.slots, T(0.0)),
        second(m.signals.slots, T(0.0)),
        gradients(m.signals.slots) {
    if constexpr (std::is_same_v<T, double>) {
      held = m.signals.start.data();
      states = m.states.data();
      numbers = m.numbers.data();
    }
  }

  std::vector<T> value, rate, second;
  std::vector<GradientOf<T>> gradients;  ///< scratch of feedback()
  const T* held = nullptr;               ///< State::u: inputs, sampled signals, integrals
  const T* states = nullptr;             ///< State::z of force elements, at the start of the step
  const T* numbers = nullptr;            ///< Compiled::numbers of laws
  double step = 0;                       ///< s, that is made from there; 0: none
  double time = std::numeric_limits<double>::quiet_NaN();  ///< that the values are of

  /// From now on evaluations continue from these, by a step. What depends on time is made anew when it is
  /// next asked for.
  void enter(const T* from_held, const T* from_states, double of_step) {
    held = from_held;
    states = from_states;
    step = of_step;
    time = std::numeric_limits<double>::quiet_NaN();
  }
};

/// A held input at a time: constant, or on a straight line to where it is set to be.
template <class T>
JetOf<T> held_input(const SignalsData::Held& h, const T* held, double time) {
  const T* at = held + h.held;
  if (!h.linear) return {at[0], T(0), T(0)};
  if constexpr (is_pack<T>) {
    // Each lane has instants of its own.
    JetOf<T> out;
    SignalsData::Held one = h;
    one.held = 0;
    for (int i = 0; i < T::lanes; ++i) {
      const double lane[] = {at[0][i], at[1][i], at[2][i], at[3][i]};
      const Jet jet = held_input(one, lane, time);
      out.value[i] = jet.value;
      out.first[i] = jet.first;
      out.second[i] = jet.second;
    }
    return out;
  } else {
    const T from = at[0], start = at[1], to = at[2], end = at[3];
    if (!(end > start) || time >= end) return {to, T(0), T(0)};
    if (time <= start) return {from, T(0), T(0)};
    const T rate = (to - from) / (end - start);
    return {from + rate * (time - start), rate, T(0)};
  }
}

/// A formula of signals, none of its own variables, with its derivatives by time.
template <class T>
JetOf<T> signal_jet(const LawData& law, const SignalValues<T>& s) {
  std::array<JetOf<T>, Formula::most_variables> x;
  for (std::size_t k = 0; k < law.slots.size(); ++k)
    x[k] = {s.value[law.slots[k]], s.rate[law.slots[k]], s.second[law.slots[k]]};
  return jet_at<T>(law.formula, x.data());
}
template <class T>
T signal_value(const LawData& law, const SignalValues<T>& s) {
  std::array<T, Formula::most_variables> x;
  for (std::size_t k = 0; k < law.slots.size(); ++k) x[k] = s.value[law.slots[k]];
  return value_at(law.formula, x.data());
}

/// Everything that time and inputs decide, once for each time.
template <class T>
void fix_signals(const SignalsData& d, double time, SignalValues<T>& s) {
  if (s.time == time) return;
  s.time = time;
  const auto put = [&](int slot, const auto& jet) {
    s.value[slot] = jet.value;
    s.rate[slot] = jet.first;
    s.second[slot] = jet.second;
  };
  put(0, Jet{time, 1, 0});
  for (const SignalsData::Held& h : d.held) put(h.slot, held_input(h, s.held, time));
  for (const SignalsData::OfTime& f : d.of_time) put(f.slot, f.function.jet(time));
  for (const SignalsData::Made& f : d.fixed) put(f.slot, signal_jet(f.law, s));
  for (const SignalsData::Integral& i : d.integrals) {
    // Of what is constant or straight over the step it is exact.
    const T from = s.held[i.held], span = time - s.held[i.held + 1], now = s.value[i.rate];
    put(i.slot, JetOf<T>{from + span * (now - 0.5 * span * s.rate[i.rate]), now, s.rate[i.rate]});
  }
}

}  // namespace mimbre
