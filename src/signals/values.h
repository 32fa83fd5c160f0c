#pragma once
#include <array>
#include <limits>
#include <vector>

#include "model/compiled.h"

/// What a step sees of time, inputs and signals: one number per slot, with two derivatives by time of those
/// that time and inputs alone decide.
namespace mimbre {

struct SignalValues {
  explicit SignalValues(const Compiled& m)
      : value(m.signals.slots, std::numeric_limits<double>::quiet_NaN()),
        rate(m.signals.slots, 0.0),
        second(m.signals.slots, 0.0),
        gradients(m.signals.slots),
        held(m.signals.start.data()),
        states(m.states.data()) {}

  std::vector<double> value, rate, second;
  std::vector<Gradient> gradients;  ///< scratch of feedback()
  const double* held;               ///< State::u: inputs, sampled signals, integrals
  const double* states;             ///< State::z of force elements, at the start of the step
  double step = 0;                  ///< s, that is made from there; 0: none
  double time = std::numeric_limits<double>::quiet_NaN();  ///< that the values are of

  /// From now on evaluations continue from these, by a step. What depends on time is made anew when it is
  /// next asked for.
  void enter(const double* from_held, const double* from_states, double of_step) {
    held = from_held;
    states = from_states;
    step = of_step;
    time = std::numeric_limits<double>::quiet_NaN();
  }
};

/// A held input at a time: constant, or on a straight line to where it is set to be.
inline Jet held_input(const SignalsData::Held& h, const double* held, double time) {
  const double* at = held + h.held;
  if (!h.linear) return {at[0], 0, 0};
  const double from = at[0], start = at[1], to = at[2], end = at[3];
  if (!(end > start) || time >= end) return {to, 0, 0};
  if (time <= start) return {from, 0, 0};
  const double rate = (to - from) / (end - start);
  return {from + rate * (time - start), rate, 0};
}

/// A formula of signals, none of its own variables, with its derivatives by time.
inline Jet signal_jet(const LawData& law, const SignalValues& s) {
  std::array<Jet, Formula::most_variables> x;
  for (std::size_t k = 0; k < law.slots.size(); ++k)
    x[k] = {s.value[law.slots[k]], s.rate[law.slots[k]], s.second[law.slots[k]]};
  return law.formula.jet(x.data());
}
inline double signal_value(const LawData& law, const SignalValues& s) {
  std::array<double, Formula::most_variables> x;
  for (std::size_t k = 0; k < law.slots.size(); ++k) x[k] = s.value[law.slots[k]];
  return law.formula.value(x.data());
}

/// Everything that time and inputs decide, once for each time.
inline void fix_signals(const SignalsData& d, double time, SignalValues& s) {
  if (s.time == time) return;
  s.time = time;
  const auto put = [&](int slot, const Jet& jet) {
    s.value[slot] = jet.value;
    s.rate[slot] = jet.first;
    s.second[slot] = jet.second;
  };
  put(0, {time, 1, 0});
  for (const SignalsData::Held& h : d.held) put(h.slot, held_input(h, s.held, time));
  for (const SignalsData::OfTime& f : d.of_time) put(f.slot, f.function.jet(time));
  for (const SignalsData::Made& f : d.fixed) put(f.slot, signal_jet(f.law, s));
  for (const SignalsData::Integral& i : d.integrals) {
    // Of what is constant or straight over the step it is exact.
    const double from = s.held[i.held], span = time - s.held[i.held + 1], now = s.value[i.rate];
    put(i.slot, {from + span * (now - 0.5 * span * s.rate[i.rate]), now, s.rate[i.rate]});
  }
}

}  // namespace mimbre
