#pragma once
#include "dynamics/relative/constraints.h"
#include "dynamics/relative/forces.h"
#include "dynamics/relative/kinematics.h"
#include "dynamics/relative/residual.h"
#include "joints/joint_kind.h"

/// The phases of an evaluation in their order.
namespace mimbre::relative {

/// Moves the common point to the first body's joint frame: for a floating root its own origin, otherwise a
/// point on the ground near it.
template <class T>
void set_origin(const Compiled& m, Workspace<T>& w, const T* q) {
  if (m.bodies.empty()) return;
  const BodyData& root = m.bodies.front();
  const FrameData& base = m.frames[root.inboard_frame];
  Vec3<T> at = Vec3<T>::Zero();
  if (joint_info(root.joint).free() && !root.reversed) at = Vec3<T>(q[root.q], q[root.q + 1], q[root.q + 2]);
  move_origin<T>(m, w, base.position.template cast<T>() + base.rotation.template cast<T>() * at);
}

/// Positions, velocities, accelerations and the equations at time t.
template <class T>
void evaluate_motion(const Compiled& m, Workspace<T>& w, double t, const T* q, const T* v, const T* a) {
  kinematics<T>(m, w, q, v, a);
  fix_signals(m.signals, t, w.signals);
  constraints<T>(m, w, q, v, a);
}

/// At that motion, r = M(q) a − Q(t, q, v) + Φzᵀ μ with μ = multipliers + factor·α Φ(q), α: `penalty`. Writes
/// mu (equations × 1) and r (velocities × 1).
template <class T>
void evaluate_residual(const Compiled& m, Workspace<T>& w, const double* penalty, double t, const T* q,
                       const T* v, const T* a, const T* multipliers, double factor, T* mu, T* r) {
  forces<T>(m, w, t, q, v, a, r);
  for (int k = 0; k < m.equations; ++k) mu[k] = multipliers[k] + factor * penalty[k] * w.phi[k];
  apply_multipliers<T>(m, w, mu, r);
  residual<T>(m, w, q, v, a, r);
}

/// Both.
template <class T>
void evaluate(const Compiled& m, Workspace<T>& w, const double* penalty, double t, const T* q, const T* v,
              const T* a, const T* multipliers, double factor, T* mu, T* r) {
  evaluate_motion<T>(m, w, t, q, v, a);
  evaluate_residual<T>(m, w, penalty, t, q, v, a, multipliers, factor, mu, r);
}

}  // namespace mimbre::relative
