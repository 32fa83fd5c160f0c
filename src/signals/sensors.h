#pragma once
#include "outputs/table.h"
#include "signals/values.h"

/// What signals see of the motion within an evaluation, and what follows from it.
namespace mimbre {

/// `frame(k)`: Motion of a frame, positions relative to `origin`; `measured(k)`: ElementState of an element;
/// `amplitudes(body)`: its amplitudes.
template <class T, class Frame, class Measured, class Amplitudes>
class SensorViewOf final : public SensorView<T> {
 public:
  SensorViewOf(const Vec3<T>& origin, const Frame& frame, const Measured& measured,
               const Amplitudes& amplitudes)
      : origin_(origin), frame_(frame), measured_(measured), amplitudes_(amplitudes) {}
  const Vec3<T>& origin() const override { return origin_; }
  Motion<T> motion(int frame) const override { return frame_(frame); }
  T measure(int element, int component) const override { return measured_(element).x[component]; }
  T rate(int element, int component) const override { return measured_(element).v[component]; }
  const T* amplitudes(int body) const override { return amplitudes_(body); }

 private:
  const Vec3<T>& origin_;
  const Frame& frame_;
  const Measured& measured_;
  const Amplitudes& amplitudes_;
};

/// What the motion alone decides of signals.
template <class T, class Frame, class Measured, class Amplitudes>
void read_sensors(const Compiled& m, const Vec3<T>& origin, const Frame& frame, const Measured& measured,
                  const Amplitudes& amplitudes, SignalValues<T>& s) {
  const SensorViewOf<T, Frame, Measured, Amplitudes> view(origin, frame, measured, amplitudes);
  for (const SignalsData::Sensor& sensor : m.signals.sensors) {
    const SensorData& d = m.sensors[sensor.sensor];
    s.value[sensor.slot] = outputs::sensor_functions<T>[static_cast<std::size_t>(d.kind)](d, view);
  }
}

/// One of the signals that follow from those.
template <class T>
void make_moving_signal(const SignalsData& d, const SignalsData::Computed& f, SignalValues<T>& s) {
  if (f.block < 0) {
    s.value[f.slot] = signal_value(f.law, s);
  } else {
    const SignalsData::Block& b = d.blocks[f.block];
    make_block(d, b, block_inputs(b, s).data(), s);
  }
}

template <class T>
void make_moving_signals(const SignalsData& d, SignalValues<T>& s) {
  make_signals(d, d.moving, d.moving_loops, s,
               [&](const SignalsData::Computed& f) { make_moving_signal(d, f, s); });
}

/// Gradients of a block's outputs by those of its inputs, `of` their formulas.
template <class T, class Of>
void block_gradients(const SignalsData& d, const SignalsData::Block& b, SignalValues<T>& s, const Of& of) {
  const BlockInputs<T> in = block_inputs(b, s);
  BlockCall<T> call = block_call(d, b, s);
  call.in = in.data();
  std::array<T, most_block_inputs * most_block_outputs> by;
  blocks::rows<T>[static_cast<std::size_t>(b.type)].slope(call, by.data());
  for (int r = 0; r < b.outputs; ++r) s.gradients[b.slot + r] = {s.value[b.slot + r], T(0), T(0)};
  for (int k = 0; k < b.inputs; ++k) {
    const GradientOf<T> g = of(b.laws[k]);
    for (int r = 0; r < b.outputs; ++r) {
      s.gradients[b.slot + r].by_first += by[r * b.inputs + k] * g.by_first;
      s.gradients[b.slot + r].by_second += by[r * b.inputs + k] * g.by_second;
    }
  }
}

/// ∂/∂x and ∂/∂v of an element's own signal by the coordinate or length that it measures, by way of the
/// signals: what a controller of an actuator's own motion adds to the tangents.
template <class T>
std::pair<T, T> feedback(const Compiled& m, const ElementData& of, SignalValues<T>& s) {
  const FeedbackPath& path = s.feedback[static_cast<std::size_t>(&of - m.elements.begin())];
  if (!path.closed) return {T(0), T(0)};
  for (const auto& [slot, is_rate] : path.own)
    s.gradients[slot] = {s.value[slot], T(is_rate ? 0 : 1), T(is_rate ? 1 : 0)};
  for (const int slot : path.given) s.gradients[slot] = {s.value[slot], T(0), T(0)};
  const auto gradient_of = [&](const LawData& law) {
    std::array<GradientOf<T>, Formula::most_variables> x;
    for (std::size_t k = 0; k < law.slots.size(); ++k) {
      const int at = law.slots[k];
      x[k] = at < m.signals.first_moving ? GradientOf<T>{s.value[at], T(0), T(0)} : s.gradients[at];
    }
    return gradient_at<T>(law.formula, x.data());
  };
  for (const int k : path.computed) {
    const SignalsData::Computed& f = m.signals.moving[k];
    if (f.block < 0)
      s.gradients[f.slot] = gradient_of(f.law);
    else
      block_gradients(m.signals, m.signals.blocks[f.block], s, gradient_of);
  }
  return {s.gradients[of.feedback].by_first, s.gradients[of.feedback].by_second};
}

}  // namespace mimbre
