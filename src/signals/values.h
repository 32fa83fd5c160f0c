#pragma once
#include <array>
#include <limits>
#include <span>
#include <vector>

#include "compile/compiled.h"
#include "math/function_values.h"
#include "signals/blocks/table.h"
#include "signals/once/feedback_paths.h"

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
        gradients(m.signals.slots),
        feedback(feedback_paths(m)),
        matrices(static_cast<std::size_t>(m.signals.matrices)) {
    if constexpr (std::is_same_v<T, double>) {
      held = m.signals.start.data();
      states = m.states.data();
      numbers = m.numbers.data();
    }
  }

  std::vector<T> value, rate, second;
  std::vector<GradientOf<T>> gradients;  ///< scratch of feedback()
  std::vector<FeedbackPath> feedback;    ///< by element
  std::vector<double> matrices;          ///< of blocks, for a step of that length:
  double matrices_of = 0;                ///< s
  const T* held = nullptr;               ///< State::u: inputs, sampled signals, integrals, blocks
  const T* states = nullptr;             ///< State::z of force elements, at the start of the step
  const T* numbers = nullptr;            ///< Compiled::numbers of laws
  double step = 0;                       ///< s, that is made from there; 0: none
  bool moves = true;                     ///< time goes on: rates count
  /// 1: friction that sticks as the step begins goes on sticking, beyond its limit too: of the first iterate
  /// of a step alone, the elastic predictor of plasticity.
  T holds = T(0);
  double time = std::numeric_limits<double>::quiet_NaN();  ///< that the values are of
  double since = 0;  ///< s, from the time that continuous blocks have their states of

  template <class AnyJet>
  void put(int slot, const AnyJet& jet) {
    value[slot] = jet.value;
    rate[slot] = jet.first;
    second[slot] = jet.second;
  }

  /// From now on evaluations continue from these, by a step. What depends on time is made anew when it is
  /// next asked for.
  void enter(const T* from_held, const T* from_states, double of_step) {
    held = from_held;
    states = from_states;
    step = of_step;
    moves = true;
    time = std::numeric_limits<double>::quiet_NaN();
  }
};

/// A held input at a time: constant, or on a straight line to where it is set to be.
template <class T>
JetOf<T> held_input(const SignalsData::HeldInput& h, const T* held, double time) {
  const T* at = held + h.held;
  if (!h.linear) return {at[0], T(0), T(0)};
  if constexpr (is_pack<T>) {
    // Each lane has instants of its own.
    JetOf<T> out;
    SignalsData::HeldInput one = h;
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

template <class T>
BlockCall<T> block_call(const SignalsData& d, const SignalsData::Block& b, const SignalValues<T>& s) {
  const T* held = s.held + b.held;
  return {d.numbers.data() + b.numbers,
          s.matrices.data() + b.matrices,
          b.function < 0 ? nullptr : &d.functions[static_cast<std::size_t>(b.function)],
          b.inputs,
          b.outputs,
          b.states,
          b.every,
          s.time,
          s.since,
          s.since > 0 || in_lane(held[0], 0) > 0.5,
          held + 1 + b.inputs,
          held + 1,
          nullptr,
          nullptr};
}

/// Of a sampled block, whose memory is `held`, at an instant h after the last one; `in`, `out`: its inputs
/// and outputs.
template <class T>
BlockCall<T> sampled_call(const SignalsData& d, const SignalsData::Block& b, const T* held, double time,
                          double h, bool begun, const T* in, T* out) {
  return {d.numbers.data() + b.numbers,
          nullptr,
          b.function < 0 ? nullptr : &d.functions[static_cast<std::size_t>(b.function)],
          b.inputs,
          b.outputs,
          b.states,
          b.every,
          time,
          h,
          begun,
          held + 1 + b.inputs,
          held + 1,
          in,
          out};
}

template <class T>
using BlockInputs = std::array<T, most_block_inputs>;

template <class T>
BlockInputs<T> block_inputs(const SignalsData::Block& b, const SignalValues<T>& s) {
  BlockInputs<T> in;
  for (int k = 0; k < b.inputs; ++k) in[k] = signal_value(b.laws[k], s);
  return in;
}

/// What a continuous block makes of these inputs.
template <class T>
void make_block(const SignalsData& d, const SignalsData::Block& b, const T* in, SignalValues<T>& s) {
  BlockCall<T> call = block_call(d, b, s);
  call.in = in;
  call.out = s.value.data() + b.slot;
  blocks::rows<T>[static_cast<std::size_t>(b.type)].output(call);
}

/// The same with derivatives by time; not a number where they are not known.
template <class T>
void make_block_jets(const SignalsData& d, const SignalsData::Block& b, SignalValues<T>& s) {
  const auto jets = blocks::rows<T>[static_cast<std::size_t>(b.type)].jets;
  const BlockInputs<T> in = block_inputs(b, s);
  std::array<JetOf<T>, most_block_outputs> out;
  if (jets) {
    std::array<JetOf<T>, most_block_inputs> of;
    for (int k = 0; k < b.inputs; ++k) of[k] = signal_jet(b.laws[k], s);
    BlockCall<T> call = block_call(d, b, s);
    call.in = in.data();
    jets(call, of.data(), out.data());
  } else {
    make_block(d, b, in.data(), s);
    const T unknown(std::numeric_limits<double>::quiet_NaN());
    for (int k = 0; k < b.outputs; ++k) out[k] = {s.value[b.slot + k], unknown, unknown};
  }
  for (int k = 0; k < b.outputs; ++k) s.put(b.slot + k, out[k]);
}

/// Rounds of a loop of signals at most.
constexpr int most_signal_rounds = 60;

/// Whether what a block makes still changes by more than round-off, and at the end by more than round-off of
/// what it is made of: before this round it was `before`.
template <class T>
auto has_settled(const T& now, const T& before) {
  using std::abs;
  constexpr double round_off = 1e-15;
  return abs(T(now - before)) <= round_off * abs(now);
}
template <class T>
auto is_unsettled(const T& now, const T& before, std::span<const T> made_of) {
  using std::abs;
  constexpr double unsettled = 1e-9;
  T size = abs(now);
  for (const T& in : made_of) size = select(abs(in) > size, T(abs(in)), size);
  return abs(T(now - before)) > T(unsettled) * size;
}

/// What blocks that close loops make at first: that of their inputs at the step's start.
template <class T>
void begin_signal_loop(const SignalsData& d, const SignalsData::Block& b, SignalValues<T>& s) {
  make_block(d, b, s.held + b.held + 1, s);
  for (int k = 0; k < b.outputs; ++k) s.rate[b.slot + k] = s.second[b.slot + k] = T(0);
}

/// Makes a list of signals in their order by `make_one`. Where blocks that do not feed through close loops,
/// what they make is at first that of their inputs at the step's start, and then goes around until nothing
/// changes any more: of a loop that is faster than the step can resolve it is not a number, and the step
/// fails.
template <class T, class MakeOne>
void make_signals(const SignalsData& d, const Array<SignalsData::Computed>& list, bool loops,
                  SignalValues<T>& s, const MakeOne& make_one) {
  if (loops)
    for (const SignalsData::Computed& made : list)
      if (made.block >= 0 && d.blocks[made.block].ahead) begin_signal_loop(d, d.blocks[made.block], s);
  for (int round = 0; round < (loops ? most_signal_rounds : 1); ++round) {
    bool settled = true;
    for (const SignalsData::Computed& made : list) {
      if (made.block < 0 || !d.blocks[made.block].ahead) {
        make_one(made);
        continue;
      }
      const SignalsData::Block& b = d.blocks[made.block];
      std::array<T, most_block_outputs> before;
      for (int k = 0; k < b.outputs; ++k) before[k] = s.value[b.slot + k];
      make_one(made);
      const BlockInputs<T> inputs = block_inputs(b, s);
      const std::span<const T> made_of(inputs.data(), static_cast<std::size_t>(b.inputs));
      for (int k = 0; k < b.outputs; ++k) {
        const T now = s.value[b.slot + k];
        settled = settled && all(has_settled(now, before[k]));
        if (round + 1 == most_signal_rounds)
          s.value[b.slot + k] =
              select(is_unsettled(now, before[k], made_of), T(std::numeric_limits<double>::quiet_NaN()), now);
      }
    }
    if (settled && round > 0) return;
  }
}

/// How long ago continuous blocks had their states, and what that makes of linear ones.
template <class T>
void enter_blocks(const SignalsData& d, SignalValues<T>& s) {
  if (d.clock < 0) return;
  s.since = s.time - in_lane(s.held[d.clock], 0) > 0.5 * s.step ? s.step : 0;
  if (s.since == 0 || s.since == s.matrices_of) return;
  s.matrices_of = s.since;
  for (const SignalsData::Block& b : d.blocks)
    if (const auto prepare = blocks::rows<T>[static_cast<std::size_t>(b.type)].prepare;
        prepare && !(b.every > 0))
      prepare(b, d.numbers.data() + b.numbers, s.since, s.matrices.data() + b.matrices);
}

/// Everything that time and inputs decide, with `of_input(h)` the value and derivatives of an input.
template <class T, class OfInput>
void fix_signals_by(const SignalsData& d, double time, SignalValues<T>& s, const OfInput& of_input) {
  s.time = time;
  s.put(0, Jet{time, 1, 0});
  for (const SignalsData::HeldInput& h : d.held) s.put(h.slot, of_input(h));
  for (const SignalsData::OfTime& f : d.of_time) s.put(f.slot, f.function.jet(time));
  enter_blocks(d, s);
  make_signals(d, d.fixed, d.fixed_loops, s, [&](const SignalsData::Computed& f) {
    if (f.block < 0)
      s.put(f.slot, signal_jet(f.law, s));
    else
      make_block_jets(d, d.blocks[f.block], s);
  });
  for (const SignalsData::Integral& i : d.integrals) {
    // Of what is constant or straight over the step it is exact.
    const T from = s.held[i.held], span = time - s.held[i.held + 1], now = s.value[i.rate];
    s.put(i.slot, JetOf<T>{from + span * (now - 0.5 * span * s.rate[i.rate]), now, s.rate[i.rate]});
  }
}

/// The same of inputs as they are held, once for each time.
template <class T>
void fix_signals(const SignalsData& d, double time, SignalValues<T>& s) {
  if (s.time == time) return;
  fix_signals_by(d, time, s, [&](const SignalsData::HeldInput& h) { return held_input(h, s.held, time); });
}

}  // namespace mimbre
