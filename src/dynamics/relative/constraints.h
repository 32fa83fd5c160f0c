#pragma once
#include "constraints/table.h"
#include "dynamics/relative/workspace.h"
#include "forces/relative_motion.h"

/// Loop closure of cut joints, prescribed motion of driven coordinates, and constraints between bodies.
namespace mimbre::relative {

/// Φ, Φ̇, Φ̈ of constraints, with the covectors of what they have between two frames, and what they remember.
template <class T>
void constrain_bodies(const Compiled& m, Workspace<T>& w, const T* q, const T* v, const T* a) {
  for (const ConstraintData& c : m.constraints) {
    T* const phi = w.phi.data() + c.first_equation;
    T* const first = w.phi_dot.data() + c.first_equation;
    T* const second = w.phi_ddot.data() + c.first_equation;
    for (int r = 0; r < c.count; ++r) phi[r] = first[r] = second[r] = T(0);
    if (c.of_coordinates) phi[0] = T(-c.numbers[0]);
    const int terms = static_cast<int>(c.terms.size());
    for (int t = 0; t < terms; ++t) {
      const ConstraintTerm& term = c.terms[t];
      if (term.body >= 0) {
        const T factor = T(term.factor);
        phi[0] += factor * q[term.q];
        first[0] += factor * v[term.v];
        second[0] += factor * a[term.v];
        continue;
      }
      const Motion<T>&A = w.frames[term.frame_a], &B = w.frames[term.frame_b];
      const RelativeMotion<T> motion = relative_motion<T>(A, B);
      ScalarEquation<T> equation[constraints::most_equations];
      constraints::equations<T>[c.kind](
          {c, term, motion, nullptr, w.signals.states + c.states, w.constraint_states.data() + c.next_states,
           w.rate_time, c.road < 0 ? nullptr : &m.roads[c.road]},
          equation);
      for (int r = 0; r < c.count; ++r) {
        phi[r] += equation[r].value;
        first[r] += equation[r].rate(motion);
        second[r] += equation[r].second(motion);
        const Vec3<T> linear = A.rotation * equation[r].linear;
        w.constraint_linear[c.covectors + r * terms + t] = linear;
        w.constraint_angular[c.covectors + r * terms + t] =
            A.rotation * equation[r].angular + B.position.cross(linear);
      }
    }
  }
}

/// Φ, Φ̇, Φ̈ of all equations from the frames' motion, and the covectors w of loop equations about the common
/// point: Φ̇ = w · (Z_b − Z_a), Z the frames' spatial velocities (Lugrís 2008, 2.121–2.123, written per
/// equation). The signals have to be those of the time.
template <class T>
void constraints(const Compiled& m, Workspace<T>& w, const T* q, const T* v, const T* a) {
  for (const LoopData& loop : m.loops) {
    const Motion<T>&A = w.frames[loop.frame_a], &B = w.frames[loop.frame_b];
    const Vec3<T> d = B.position - A.position;
    const Vec3<T> wd = A.omega.cross(d);
    // Velocity and acceleration of b's origin seen from frame a.
    const Vec3<T> d1 = B.velocity - A.velocity - wd;
    const Vec3<T> d2 = B.acceleration - A.acceleration - A.alpha.cross(d) - A.omega.cross(wd + T(2) * d1);
    for (int r = 0; r < loop.count; ++r) {
      const LoopClosure& e = loop.closure[r];
      const int k = loop.first_equation + r;
      const Vec3<T> x = A.rotation.col(e.axis_a);
      if (e.kind == LoopClosure::Kind::distance) {
        w.phi[k] = x.dot(d);
        w.phi_dot[k] = x.dot(d1);
        w.phi_ddot[k] = x.dot(d2);
        w.covector_linear[k] = x;
        w.covector_angular[k] = B.position.cross(x);
      } else {
        const Vec3<T> z = B.rotation.col(e.axis_b);
        const Vec3<T> xd = A.omega.cross(x), zd = B.omega.cross(z);
        const Vec3<T> xdd = A.alpha.cross(x) + A.omega.cross(xd), zdd = B.alpha.cross(z) + B.omega.cross(zd);
        w.phi[k] = x.dot(z);
        w.phi_dot[k] = xd.dot(z) + x.dot(zd);
        w.phi_ddot[k] = xdd.dot(z) + T(2) * xd.dot(zd) + x.dot(zdd);
        w.covector_linear[k].setZero();
        w.covector_angular[k] = z.cross(x);
      }
    }
  }
  for (const DriveData& d : m.drives) {
    w.phi[d.equation] = q[d.q] - w.signals.value[d.slot];
    w.phi_dot[d.equation] = v[d.v] - w.signals.rate[d.slot];
    w.phi_ddot[d.equation] = a[d.v] - w.signals.second[d.slot];
  }
  constrain_bodies<T>(m, w, q, v, a);
}

/// Adds the wrenches −Φzᵀ μ of multipliers μ (on frames; of tree joints' coordinates on `generalised`, size
/// velocities).
template <class T>
void apply_multipliers(const Compiled& m, Workspace<T>& w, const T* mu, T* generalised) {
  for (const LoopData& loop : m.loops) {
    const Motion<T>&A = w.frames[loop.frame_a], &B = w.frames[loop.frame_b];
    const Vec3<T> d = B.position - A.position;
    Vec3<T> force = Vec3<T>::Zero(), moment = Vec3<T>::Zero();  // on a
    for (int r = 0; r < loop.count; ++r) {
      const int k = loop.first_equation + r;
      if (loop.closure[r].kind == LoopClosure::Kind::distance)
        force += mu[k] * w.covector_linear[k];
      else
        moment += mu[k] * w.covector_angular[k];
    }
    w.wrenches[loop.frame_a].force += force;
    w.wrenches[loop.frame_a].moment += moment + d.cross(force);
    w.wrenches[loop.frame_b].force -= force;
    w.wrenches[loop.frame_b].moment -= moment;
  }
  for (const DriveData& d : m.drives) generalised[d.v] += mu[d.equation];
  for (const ConstraintData& c : m.constraints) {
    const int terms = static_cast<int>(c.terms.size());
    for (int t = 0; t < terms; ++t) {
      const ConstraintTerm& term = c.terms[t];
      if (term.body >= 0) {
        generalised[term.v] += T(term.factor) * mu[c.first_equation];
        continue;
      }
      Vec3<T> force = Vec3<T>::Zero(), moment = Vec3<T>::Zero();  // on a, about the common point
      for (int r = 0; r < c.count; ++r) {
        force += mu[c.first_equation + r] * w.constraint_linear[c.covectors + r * terms + t];
        moment += mu[c.first_equation + r] * w.constraint_angular[c.covectors + r * terms + t];
      }
      w.wrenches[term.frame_a].force += force;
      w.wrenches[term.frame_a].moment += moment - w.frames[term.frame_a].position.cross(force);
      w.wrenches[term.frame_b].force -= force;
      w.wrenches[term.frame_b].moment -= moment - w.frames[term.frame_b].position.cross(force);
    }
  }
}

}  // namespace mimbre::relative
