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

template <class T, class Frame, class Measured, class Amplitudes>
void sense(const Compiled& m, const Vec3<T>& origin, const Frame& frame, const Measured& measured,
           const Amplitudes& amplitudes, SignalValues<T>& s) {
  const SensorViewOf<T, Frame, Measured, Amplitudes> view(origin, frame, measured, amplitudes);
  for (const SignalsData::Sensor& sensor : m.signals.sensors) {
    const SensorData& d = m.sensors[sensor.sensor];
    s.value[sensor.slot] = outputs::sensor_functions<T>[static_cast<std::size_t>(d.kind)](d, view);
  }
  make_signals(m.signals, m.signals.moving, m.signals.moving_loops, s, [&](const SignalsData::Computed& f) {
    if (f.block < 0) {
      s.value[f.slot] = signal_value(f.law, s);
    } else {
      const SignalsData::Block& b = m.signals.blocks[f.block];
      make_block(m.signals, b, block_inputs(b, s).data(), s);
    }
  });
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

/// ∂(slot)/∂x and ∂/∂v of the coordinate or length that element `of` measures, by way of the signals: what a
/// controller of an actuator's own motion adds to the tangents.
template <class T>
std::pair<T, T> feedback(const Compiled& m, const ElementData& of, int slot, SignalValues<T>& s) {
  const auto same = [&](const SensorData& sensor) {
    if (sensor.element < 0) return false;
    const ElementData& e = m.elements[sensor.element];
    if (e.measure != of.measure) return false;
    if (of.measure == Measure::coordinate) return e.joint_spec == of.joint_spec && e.local == of.local;
    return of.measure == Measure::distance && e.frame_a == of.frame_a && e.frame_b == of.frame_b;
  };
  bool any = false;
  for (const SignalsData::Sensor& sensor : m.signals.sensors) {
    const SensorData& d = m.sensors[sensor.sensor];
    GradientOf<T> g{s.value[sensor.slot], T(0), T(0)};
    if (same(d)) {
      (d.is_rate ? g.by_second : g.by_first) = T(1);
      any = true;
    }
    s.gradients[sensor.slot] = g;
  }
  if (!any) return {T(0), T(0)};
  const auto gradient_of = [&](const LawData& law) {
    std::array<GradientOf<T>, Formula::most_variables> x;
    for (std::size_t k = 0; k < law.slots.size(); ++k) {
      const int at = law.slots[k];
      x[k] = at < m.signals.first_moving ? GradientOf<T>{s.value[at], T(0), T(0)} : s.gradients[at];
    }
    return gradient_at<T>(law.formula, x.data());
  };
  // What a block makes in a loop that it closes counts as given: it is of the order of the step.
  if (m.signals.moving_loops)
    for (const SignalsData::Computed& f : m.signals.moving)
      for (int k = 0; f.block >= 0 && k < m.signals.blocks[f.block].outputs; ++k)
        s.gradients[f.slot + k] = {s.value[f.slot + k], T(0), T(0)};
  for (const SignalsData::Computed& f : m.signals.moving) {
    if (f.block < 0)
      s.gradients[f.slot] = gradient_of(f.law);
    else
      block_gradients(m.signals, m.signals.blocks[f.block], s, gradient_of);
  }
  return {s.gradients[slot].by_first, s.gradients[slot].by_second};
}

}  // namespace mimbre
