#pragma once
#include "dynamics/natural/joint_rates.h"
#include "forces/measure.h"
#include "signals/law.h"

/// Applied forces on the bodies' base vectors and amplitudes, with the sign of the residual (minus the
/// force).
namespace mimbre::natural {

/// A frame's motion with its angular velocity; without `turning` its position and velocity alone.
/// With `turning` accelerations too, of which gravity is not taken off.
template <class T>
Motion<T> motion_of_frame(const FrameMotion<T>& f, bool turning) {
  Motion<T> out;
  out.position = f.position;
  out.velocity = f.velocity;
  if (!turning) return out;
  out.rotation = f.axes;
  out.omega = vee<T>(f.axes_velocity * f.axes.transpose());
  out.acceleration = f.acceleration;
  out.alpha = vee<T>(f.axes_acceleration * f.axes.transpose());
  return out;
}

/// What an element measures: of a joint in the tree its coordinate, which counts turns.
template <class T>
void measure_element(const Compiled& m, const Layout& l, Workspace<T>& w, const ElementData& e, const T* q,
                     ElementState<T>& s) {
  if (e.body >= 0) {
    const JointCoordinate& c = l.joint_coordinates[e.body];
    const FrameMotion<T>&A = w.frames[c.frame_a], &B = w.frames[c.frame_b];
    JointRates<T> rates;
    joint_rates<T>(e.joint, m.bodies[e.body].joint_velocities, A, B, q + c.q, rates);
    s.x[0] = q[c.q + e.local];
    s.v[0] = rates.v[e.local];
    *s.acceleration = rates.a[e.local];
    s.set_linear(0, A.axes * rates.motion.linear.col(e.local));
    s.set_angular(0, A.axes * rates.motion.angular.col(e.local));
    return;
  }
  const ElementEnds ends = ends_of(m, e, w.signals.states + e.states);
  if (ends.frame_b < 0) return leave_free(e, s);
  const bool turning = needs_axes(e.measure);
  const Motion<T> b = motion_of_frame(w.frames[ends.frame_b], turning);
  Motion<T> a;
  if (ends.frame_a >= 0) a = motion_of_frame(w.frames[ends.frame_a], turning);
  measure(m, e, &a, b, Vec3<T>(l.origin.template cast<T>()), w.signals.value.data(),
          w.signals.states + e.states, s, w.signals.step);
}

template <class T>
void sense(const Compiled& m, const Layout& l, Workspace<T>& w) {
  if (m.signals.sensors.empty()) return;
  read_sensors(
      m, Vec3<T>(l.origin.template cast<T>()),
      [&](int frame) { return motion_of_frame(w.frames[frame], true); },
      [&](int element) { return element_state(m.elements[element], w.elements.data()); },
      [&](int body) { return w.y.data() + l.bodies[body].amplitudes; }, w.signals);
  make_moving_signals(m.signals, w.signals);
}

/// Puts `factor` times the covector of an element's component on its two bodies.
template <class T>
void act_by_element(const Compiled& m, const Workspace<T>& w, const ElementData& e, int frame_a, int frame_b,
                    const ElementState<T>& s, int component, const T& factor, const Covector<T>& on_a,
                    const Covector<T>& on_b) {
  const FrameMotion<T>& B = w.frames[frame_b];
  const bool turning = has_moment(e.measure);
  const Vec3<T> force = factor * s.linear_of(component);
  const Vec3<T> moment = turning ? Vec3<T>(factor * s.angular_of(component)) : Vec3<T>(Vec3<T>::Zero());
  if (turning && frame_a >= 0)
    return act_between<T>(m, frame_a, frame_b, w.frames[frame_a], B, force, moment, on_a, on_b);
  act_on_point<T>(m.frames[frame_b], B, force, on_b);
  if (turning) act_by_moment<T>(m.frames[frame_b], B, moment, on_b);
  if (frame_a >= 0) act_on_point<T>(m.frames[frame_a], w.frames[frame_a], -force, on_a);
}

/// After kinematics; writes the elements' states, whose tangents the matrix uses.
template <class T>
void forces(const Compiled& m, const Layout& l, Workspace<T>& w, const T* q) {
  for (const ElementData& e : m.elements) {
    if (e.measure == Measure::sum) continue;
    ElementState<T> s = element_state(e, w.elements.data());
    measure_element(m, l, w, e, q, s);
  }
  measure_sums(m, w.elements.data());
  sense(m, l, w);
  for (std::size_t i = 0; i < m.elements.size(); ++i) {
    const ElementData& e = m.elements[i];
    const ElementEnds ends = ends_of(m, e, w.signals.states + e.states);
    if (ends.frame_b < 0 && e.pooled) continue;
    evaluate_law(m, e, w.signals, w.elements.data());
    if (e.measure == Measure::sum) continue;  // its legs act
    const ElementState<T> s = element_state(e, w.elements.data());
    const int body_a = e.pooled ? m.frames[ends.frame_a].body : l.elements[i].body_a,
              body_b = e.pooled ? m.frames[ends.frame_b].body : l.elements[i].body_b;
    const Covector<T> on_a = collector<T>(m, l, w, body_a), on_b = collector<T>(m, l, w, body_b);
    for (int k = 0; k < s.count; ++k)
      act_by_element(m, w, e, ends.frame_a, ends.frame_b, s, k, s.force[k], on_a, on_b);
  }
}

}  // namespace mimbre::natural
