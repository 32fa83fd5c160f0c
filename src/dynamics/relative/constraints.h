#pragma once
#include "dynamics/relative/workspace.h"

/// Loop closure of cut joints, and prescribed motion of driven coordinates.
namespace mimbre::relative {

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
}

/// Adds the wrenches −Φzᵀ μ of multipliers μ (loops: on frames; drives: on `generalised`, size velocities).
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
}

}  // namespace mimbre::relative
