#pragma once
#include "dynamics/relative/workspace.h"
#include "forces/measure.h"
#include "signals/law.h"

/// Applied forces as wrenches on frames and on joint coordinates.
namespace mimbre::relative {

/// What every element measures. Writes their states but for forces and tangents.
template <class T>
void measure_elements(const Compiled& m, Workspace<T>& w, const T* q, const T* v, const T* a) {
  for (const ElementData& e : m.elements) {
    if (e.measure == Measure::sum) continue;
    ElementState<T> s = element_state(e, w.elements.data());
    if (e.body >= 0) {
      s.x[0] = q[e.q];
      s.v[0] = v[e.v];
      *s.acceleration = a[e.v];
      continue;
    }
    const ElementEnds ends = ends_of(m, e, w.signals.states + e.states);
    if (ends.frame_b < 0) {
      leave_free(e, s);
      continue;
    }
    measure(m, e, ends.frame_a < 0 ? nullptr : &w.frames[ends.frame_a], w.frames[ends.frame_b], w.origin,
            w.signals.value.data(), w.signals.states + e.states, s, w.signals.step);
  }
  measure_sums(m, w.elements.data());
}

template <class T>
void read_sensors(const Compiled& m, Workspace<T>& w, const T* q) {
  mimbre::read_sensors(
      m, w.origin, [&](int frame) -> const Motion<T>& { return w.frames[frame]; },
      [&](int element) { return element_state(m.elements[element], w.elements.data()); },
      [&](int body) { return q + m.bodies[body].q + m.bodies[body].joint_positions; }, w.signals);
}

/// Values of the sensors and of what follows from them.
template <class T>
void sense(const Compiled& m, Workspace<T>& w, const T* q) {
  if (m.signals.sensors.empty()) return;
  read_sensors(m, w, q);
  make_moving_signals(m.signals, w.signals);
}

/// What elements measure and signals see of the motion, at a time.
template <class T>
void look(const Compiled& m, Workspace<T>& w, double time, const T* q, const T* v, const T* a) {
  fix_signals(m.signals, time, w.signals);
  measure_elements(m, w, q, v, a);
  sense(m, w, q);
}

/// Of what has been measured and seen: clears the wrenches, then adds those of all elements, whose force and
/// tangents `law(e)` finds from what they measure; `generalised` (size velocities) is set to minus the forces
/// on coordinates of the tree.
template <class T, class Law>
void act(const Compiled& m, Workspace<T>& w, T* generalised, const Law& law) {
  for (auto& wrench : w.wrenches) {
    wrench.force.setZero();
    wrench.moment.setZero();
  }
  for (int k = 0; k < m.velocities; ++k) generalised[k] = T(0);
  for (const ElementData& e : m.elements) {
    const ElementEnds ends = ends_of(m, e, w.signals.states + e.states);
    if (ends.frame_b < 0 && e.pooled) continue;
    law(e);
    if (e.measure == Measure::sum) continue;  // its legs act
    const ElementState<T> s = element_state(e, w.elements.data());
    if (e.body >= 0) {
      generalised[e.v] += s.force[0];
      continue;
    }
    for (int k = 0; k < s.count; ++k) {
      const Vec3<T> force = s.force[k] * s.linear_of(k);
      w.wrenches[ends.frame_b].force -= force;
      if (ends.frame_a >= 0) w.wrenches[ends.frame_a].force += force;
      if (!has_moment(e.measure)) continue;
      const Vec3<T> moment = s.force[k] * s.angular_of(k);
      w.wrenches[ends.frame_b].moment -= moment;
      if (ends.frame_a < 0) continue;
      const Vec3<T> arm = w.frames[ends.frame_b].position - w.frames[ends.frame_a].position;
      w.wrenches[ends.frame_a].moment += moment + arm.cross(force);
    }
  }
}

/// Both by the elements' own laws; of inertia that elements have it takes the force for accelerations a.
/// Writes the elements' states, whose tangents the matrix uses.
template <class T>
void forces(const Compiled& m, Workspace<T>& w, double time, const T* q, const T* v, const T* a,
            T* generalised) {
  look(m, w, time, q, v, a);
  act(m, w, generalised, [&](const ElementData& e) { evaluate_law(m, e, w.signals, w.elements.data()); });
}

}  // namespace mimbre::relative
