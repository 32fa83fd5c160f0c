#pragma once
#include "dynamics/natural/constraints.h"
#include "dynamics/natural/forces.h"
#include "dynamics/natural/inertia.h"
#include "dynamics/natural/kinematics.h"

/// The phases of an evaluation in their order.
namespace mimbre::natural {

/// After kinematics and constraints at the same q: r = M(q) a − Q(t, q, v) + Φqᵀ μ (unknowns × 1).
template <class T>
void residual(const Compiled& m, const Layout& l, Workspace<T>& w, const T* q, const T* mu, T* r) {
  for (Base<T>& f : w.forces) f.setZero();
  for (T& x : w.modal) x = T(0);
  forces<T>(m, l, w, q);
  apply_multipliers<T>(m, l, w, q, mu);
  inertia<T>(m, l, w);
  for (int k = 0; k < l.unknowns; ++k) r[k] = T(0);
  for (std::size_t i = 0; i < l.bodies.size(); ++i) {
    const Body& b = l.bodies[i];
    for (int k = 0; k < b.unknown; ++k) {
      const Vec3<T> f = w.forces[i] * b.base.col(k).template cast<T>();
      T* out = r + 3 * b.variables[k];
      for (int c = 0; c < 3; ++c) out[c] += f[c];
    }
    if (m.bodies[i].modes == 0) continue;
    fold(m.flexible[m.bodies[i].flexible], w.y.data() + b.amplitudes, w.modal.data() + b.amplitudes);
    for (int k = 0; k < m.bodies[i].modes; ++k) r[b.q + k] = w.modal[b.amplitudes + k];
  }
}

}  // namespace mimbre::natural
