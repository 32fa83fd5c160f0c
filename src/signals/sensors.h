#pragma once
#include <cmath>

#include "forces/motion.h"
#include "math/elementary.h"
#include "signals/values.h"

/// What signals see of the motion within an evaluation, and what follows from it.
namespace mimbre {

/// A sensor's value. `frame(k)`: Motion of a frame, positions relative to `origin`; `measured(k)`:
/// ElementState of an element; `amplitudes(body)`: its amplitudes.
template <class T, class Frame, class Measured, class Amplitudes>
T sensor_value(const SensorData& s, const Vec3<T>& origin, const Frame& frame, const Measured& measured,
               const Amplitudes& amplitudes) {
  using Kind = spec::Output::Kind;
  using mimbre::atan2, mimbre::hypot;
  const auto shapes = [&] {
    if (s.shapes.empty()) return T(0);
    const T* y = amplitudes(s.body);
    T sum(0);
    for (std::size_t k = 0; k < s.shapes.size(); ++k) sum += s.shapes[k] * y[k];
    return sum;
  };
  switch (s.kind) {
    case Kind::position:
      return frame(s.frame).position[s.component] + origin[s.component];
    case Kind::velocity:
      return frame(s.frame).velocity[s.component];
    case Kind::angular_velocity: {
      const Motion<T> here = frame(s.frame);
      return (s.own_axes ? Vec3<T>(here.rotation.transpose() * here.omega) : here.omega)[s.component];
    }
    case Kind::roll: {
      const Mat3<T> r = frame(s.frame).rotation;
      return atan2(r(2, 1), r(2, 2));
    }
    case Kind::pitch: {
      const Mat3<T> r = frame(s.frame).rotation;
      return atan2(T(-r(2, 0)), T(hypot(r(2, 1), r(2, 2))));
    }
    case Kind::yaw: {
      const Mat3<T> r = frame(s.frame).rotation;
      return atan2(r(1, 0), r(0, 0));
    }
    case Kind::displacement: {
      const Motion<T> reference = frame(s.reference);
      return s.direction.template cast<T>().dot(reference.rotation.transpose() *
                                                (frame(s.frame).position - reference.position)) +
             s.offset;
    }
    case Kind::joint_position:
    case Kind::spring_length:
    case Kind::element_measure:
      return measured(s.element).x[s.component] + s.offset;
    case Kind::joint_velocity:
    case Kind::element_rate:
      return measured(s.element).v[s.component];
    case Kind::deflection:
    case Kind::modal_amplitude:
      return shapes();
    default:
      return T(std::numeric_limits<double>::quiet_NaN());  // refused by the compiler
  }
}

template <class T, class Frame, class Measured, class Amplitudes>
void sense(const Compiled& m, const Vec3<T>& origin, const Frame& frame, const Measured& measured,
           const Amplitudes& amplitudes, SignalValues<T>& s) {
  for (const SignalsData::Sensor& sensor : m.signals.sensors)
    s.value[sensor.slot] = sensor_value(m.sensors[sensor.sensor], origin, frame, measured, amplitudes);
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
  using Kind = spec::Output::Kind;
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
      const bool rate = d.kind == Kind::joint_velocity || d.kind == Kind::element_rate;
      (rate ? g.by_second : g.by_first) = T(1);
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
