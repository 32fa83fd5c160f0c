#pragma once
#include <type_traits>

#include "dynamics/amplitudes.h"
#include "dynamics/elasticity.h"
#include "dynamics/flexible.h"
#include "dynamics/frame_turn.h"
#include "dynamics/geometric.h"
#include "dynamics/relative/workspace.h"

/// Inverse dynamics: generalised forces that the motion needs minus those that act, leaves to root.
namespace mimbre::relative {

/// Inertia wrench of a body about its origin, in body axes, for acceleration `acc` of the origin (minus
/// gravity).
template <class T>
struct BodyWrench {
  Vec3<T> force, moment;
};

/// Rigid body: f = m a + α × m̄ + ω × (ω × m̄), n = m̄ × a + J α + ω × J ω.
template <class T>
BodyWrench<T> rigid_inertia(const BodyData& b, const Vec3<T>& acc, const Vec3<T>& omega,
                            const Vec3<T>& alpha) {
  const Vec3<T> moment = b.first_moment.template cast<T>();
  const Mat3<T> inertia = b.inertia.template cast<T>();
  BodyWrench<T> w;
  w.force = T(b.mass) * acc + alpha.cross(moment) + omega.cross(omega.cross(moment));
  w.moment = moment.cross(acc) + turned<T>(inertia, alpha) + omega.cross(turned<T>(inertia, omega));
  return w;
}

/// Flexible body by shape integrals, all in body axes (Lugrís 2008, 3.51–3.71, evaluated in the body frame):
///   f = m a + α × m̄ + S ÿ + ω × (ω × m̄ + 2 S ẏ)
///   n = m̄ × a + J α + C ÿ + ω × J ω + 2 (tr(D) ω − Dᵀ ω),           D_ij = ∫ r̄_i u̇_j dm
///   e = Sᵀ a + Cᵀ α + Mff ÿ + Σ_ij (ω_i ω_j − ω² δ_ij) S'^i_j + 2 ω · ∫ u̇ × X dm + K y + C_d ẏ
/// Adds e to `elastic` (padded). Without the terms that the model neglects.
template <class T>
BodyWrench<T> flexible_inertia(const BodyData& b, const FlexibleData& f, const InertiaRows<T>& rows,
                               const T* y, const T* yd, const T* ydd, const Vec3<T>& acc, const Vec3<T>& w,
                               const Vec3<T>& alpha, T* elastic) {
  using Term = InertiaTerm;
  const auto keeps = [&](Term term) { return !b.neglected.has(term); };
  const int s = f.stride;
  const Vec3<T> moment = deformed_first_moment<T>(b, f, y), sy2 = times(f.S, ydd);
  const Mat3<T> p = deformed_second_moment<T>(b, f, rows, y);
  const Mat3<T> inertia = p.trace() * Mat3<T>::Identity() - p;
  const bool plain = turns_undeformed(b), turns = keeps(Term::rotation_coupling) && !plain,
             drags = keeps(Term::coriolis_body);
  Mat3<T> d, e;  // ∫ r̄_i u̇_j dm, ∫ r̄_i ü_j dm
  const T *d_rows = rows.of(Term::coriolis_body_deformed),
          *e_rows = rows.of(Term::rotation_coupling_deformed);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int at = (3 * i + j) * s;
      if (drags) d(i, j) = dot(d_rows + at, yd, s);
      if (turns) e(i, j) = dot(e_rows + at, ydd, s);
    }
  BodyWrench<T> out;
  out.force = T(b.mass) * acc + alpha.cross(moment) + sy2;
  out.moment = moment.cross(acc) + turned<T>(inertia, alpha);
  if (plain)
    out.moment += times(f.C, ydd);
  else if (turns)
    out.moment += Vec3<T>(e(1, 2) - e(2, 1), e(2, 0) - e(0, 2), e(0, 1) - e(1, 0));
  out.moment += w.cross(turned<T>(inertia, w));
  if (drags) {
    out.force += w.cross(w.cross(moment) + T(2) * times(f.S, yd));
    out.moment += T(2) * (d.trace() * w - turned_back<T>(d, w));
  } else {
    out.force += w.cross(w.cross(moment));
  }

  add_transposed<T>(f.S, acc, elastic);
  if (plain) add_transposed<T>(f.C, alpha, elastic);
  // Coefficients of the rows S'^i_j: centrifugal, and Cᵀ α (C_a = S'^b_c − S'^c_b).
  const bool centrifugal = keeps(Term::centrifugal);
  Mat3<T> g = Mat3<T>::Zero(), turning = Mat3<T>::Zero();
  if (centrifugal) g = w * w.transpose() - w.squaredNorm() * Mat3<T>::Identity();
  if (turns) turning = skew<T>(alpha).transpose();
  const T *g_rows = rows.of(centrifugal ? Term::centrifugal_deformed : Term::rotation_coupling_deformed),
          *turning_rows = rows.of(Term::rotation_coupling_deformed);
  const bool two = centrifugal && turns && g_rows != turning_rows, coriolis = keeps(Term::coriolis_modes);
  if (!two) g += turning;
  const T twice[3] = {T(2) * w[0], T(2) * w[1], T(2) * w[2]};
  by_lanes<T>(elastic, s, [&](auto sum, const auto& row) {
    const auto add = [&](const Mat3<T>& by, const T* from) {
      for (int r = 0; r < 9; ++r) sum = multiply_add(row.all(by(r / 3, r % 3)), row(from + r * s), sum);
    };
    if (centrifugal || turns) add(g, g_rows);
    if (two) add(turning, turning_rows);
    for (int l = 0; coriolis && l < f.modes; ++l) {
      const double* n = f.coriolis.data() + static_cast<std::ptrdiff_t>(l) * 3 * s;
      const auto one = row.all(twice[0]) * row(n), both = multiply_add(row.all(twice[1]), row(n + s), one),
                 all = multiply_add(row.all(twice[2]), row(n + 2 * s), both);
      sum = multiply_add(row.all(yd[l]), all, sum);
    }
    return sum;
  });
  if (f.identity_mass)
    for (int k = 0; k < s; ++k) elastic[k] += ydd[k];
  else
    for (int l = 0; l < f.modes; ++l)
      for (int k = 0; k < s; ++k) elastic[k] = multiply_add(ydd[l], f.mass(l, k), elastic[k]);
  add_elasticity(f, y, yd, elastic);
  return out;
}

/// Generalised force of a frame's wrench on the modes of its body: out += Xᵀ f̄ + (J Xθ)ᵀ n̄, f, n in global
/// axes.
template <class T>
void frame_modal_force(const FrameData& f, const Motion<T>& body, const T* y, const Vec3<T>& force,
                       const Vec3<T>& moment, T* out) {
  add_transposed<T>(f.X, turned_back<T>(body.rotation, force), out);
  if (f.turns) add_moment<T>(f, y, turned_back<T>(body.rotation, moment), out);
}

/// out = M z̈ − Q + (wrenches already on the frames, taken as acting), after kinematics, forces and
/// constraints. On entry `out` holds generalised forces of joint springs and drives (with the sign of the
/// residual).
template <class T>
void residual(const Compiled& m, Workspace<T>& w, const T* q, const T* v, const T* a, T* out) {
  for (std::size_t i = m.bodies.size(); i-- > 0;) {
    const BodyData& b = m.bodies[i];
    const Motion<T>& motion = w.bodies[i];
    const Mat3<T>& A = motion.rotation;
    const Vec3<T> acc = turned_back<T>(A, motion.acceleration), omega = turned_back<T>(A, motion.omega),
                  alpha = turned_back<T>(A, motion.alpha);
    BodyWrench<T> inertia;
    T* y = w.scratch.data();
    T* elastic = y;
    if (b.modes == 0) {
      inertia = rigid_inertia<T>(b, acc, omega, alpha);
    } else {
      const FlexibleData& f = m.flexible[b.flexible];
      const int s = f.stride;
      T *yd = y + s, *ydd = y + 2 * s;
      elastic = y + 3 * s;
      for (int k = 0; k < b.modes; ++k) {
        y[k] = q[b.q + b.joint_positions + k];
        yd[k] = v[b.v + b.joint_velocities + k];
        ydd[k] = a[b.v + b.joint_velocities + k];
      }
      for (int k = b.modes; k < s; ++k) y[k] = yd[k] = ydd[k] = T(0);
      extend(f, y);
      extend(f, y, yd);
      extend(f, y, yd, ydd);
      for (int k = 0; k < s; ++k) elastic[k] = T(0);
      if (w.projections.empty()) {
        const InertiaRows<T> rows =
            deform_inertia_rows<T>(b, f, y, w.integrals.data() + w.integral_offset[i]);
        inertia = flexible_inertia<T>(b, f, rows, y, yd, ydd, acc, omega, alpha, elastic);
        if (b.elastodynamic) inertia = rigid_inertia<T>(b, acc, omega, alpha);
      } else if constexpr (std::is_same_v<T, double>) {
        const projection::Wrench wrench = projection::inertia_wrench(w.projections[b.flexible], w.projection,
                                                                     acc, omega, alpha, y, yd, ydd, elastic);
        inertia = {wrench.force, wrench.moment};
        add_elasticity(f, y, yd, elastic);
      }
    }
    if (b.modes > 0) {
      const GeometricData& g = m.flexible[b.flexible].geometric;
      if (!g.empty()) {
        const T* ydd = y + 2 * m.flexible[b.flexible].stride;
        w.stress[i] = geometric::stress_motion<T>(g, omega, acc, alpha, ydd);
        geometric::add_inertial_forces<T>(g, w.stress[i], y, elastic);
        geometric::add_boundary_forces<T>(g, y, y + 4 * m.flexible[b.flexible].stride, elastic);
      }
    }
    // About the common point.
    Vec3<T> force = turned<T>(A, inertia.force);
    Vec3<T> moment = turned<T>(A, inertia.moment) + motion.position.cross(force);
    for (int k = b.first_frame; k < b.last_frame; ++k) {
      const Wrench<T>& wrench = w.wrenches[k];
      force -= wrench.force;
      moment -= wrench.moment + w.frames[k].position.cross(wrench.force);
      const FrameData& f = m.frames[k];
      if (f.flexible >= 0 || f.bends)
        frame_modal_force<T>(f, motion, y, Vec3<T>(-wrench.force), Vec3<T>(-wrench.moment), elastic);
    }
    // The subtree's wrench passes through the body's own joint: to the joint coordinates and to the parent's
    // frame.
    const FrameData& own = m.frames[b.outboard_frame];
    if (own.bends) {
      const Vec3<T> place = motion.position + turned<T>(A, own.position.template cast<T>());
      frame_modal_force<T>(own, motion, y, Vec3<T>(-force), Vec3<T>(-(moment - place.cross(force))), elastic);
    } else if (own.flexible >= 0) {
      // Its own modes move the body away from the joint.
      Motion<T> at;
      frame_motion<T>(own, motion, y, y + m.flexible[b.flexible].stride,
                      y + 2 * m.flexible[b.flexible].stride, at);
      frame_modal_force<T>(own, motion, y, Vec3<T>(-force), Vec3<T>(-(moment - at.position.cross(force))),
                           elastic);
    }
    for (int j = 0; j < b.joint_velocities; ++j)
      out[b.v + j] += w.joint_linear[b.v + j].dot(force) + w.joint_angular[b.v + j].dot(moment);
    if (b.modes > 0) fold(m.flexible[b.flexible], y, elastic);
    for (int k = 0; k < b.modes; ++k) out[b.v + b.joint_velocities + k] += elastic[k];
    w.transmitted[i] = {force, moment};
    Wrench<T>& parent = w.wrenches[b.inboard_frame];
    parent.force -= force;
    parent.moment -= moment - w.frames[b.inboard_frame].position.cross(force);
  }
}

/// Adds to r the part of the residual by which loads of inertia stiffen bodies, for the motion that the
/// bodies have and for amplitudes that accelerate by a.
template <class T>
void add_loads_of_inertia(const Compiled& m, Workspace<T>& w, const T* q, const T* a, T* r) {
  for (std::size_t i = 0; i < m.bodies.size(); ++i) {
    const BodyData& b = m.bodies[i];
    if (b.modes == 0 || m.flexible[b.flexible].geometric.empty()) continue;
    const FlexibleData& f = m.flexible[b.flexible];
    const Motion<T>& motion = w.bodies[i];
    const Mat3<T> to_body = motion.rotation.transpose();
    T *y = w.scratch.data(), *ydd = y + f.stride, *forces = ydd + f.stride;
    copy_modes(b, q + b.q + b.joint_positions, f.stride, y);
    copy_modes(b, a + b.v + b.joint_velocities, f.stride, ydd);
    std::fill(forces, forces + f.stride, T(0));
    geometric::add_inertial_forces(
        f.geometric,
        geometric::stress_motion<T>(f.geometric, to_body * motion.omega, to_body * motion.acceleration,
                                    to_body * motion.alpha, ydd),
        y, forces);
    for (int k = 0; k < b.modes; ++k) r[b.v + b.joint_velocities + k] += forces[k];
  }
}

}  // namespace mimbre::relative
