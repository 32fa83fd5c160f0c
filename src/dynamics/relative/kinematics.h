#pragma once
#include "dynamics/amplitudes.h"
#include "dynamics/deformation.h"
#include "dynamics/relative/workspace.h"
#include "joints/table.h"

/// Positions, velocities and accelerations from the root to the leaves.
namespace mimbre::relative {

/// Motion of a frame from that of its body. y, ẏ, ÿ: the body's padded amplitudes.
template <class T>
void frame_motion(const FrameData& f, const Motion<T>& body, const T* y, const T* yd, const T* ydd,
                  Motion<T>& out) {
  const Mat3<T>& A = body.rotation;
  if (f.flexible < 0) {
    const Vec3<T> r = turned<T>(A, f.position.template cast<T>());
    const Vec3<T> wr = body.omega.cross(r);
    out.rotation = composed<T>(A, Mat3<T>(f.rotation.template cast<T>()));
    out.position = body.position + r;
    out.velocity = body.velocity + wr;
    out.omega = body.omega;
    out.acceleration = body.acceleration + body.alpha.cross(r) + body.omega.cross(wr);
    out.alpha = body.alpha;
    return;
  }
  Deformation<T> d;
  deform(f, y, yd, ydd, d);
  const Vec3<T> r = turned<T>(A, d.position), v = turned<T>(A, d.velocity);
  const Vec3<T> wr = body.omega.cross(r);
  out.rotation = composed<T>(A, d.rotation);
  out.position = body.position + r;
  out.velocity = body.velocity + wr + v;
  out.acceleration = body.acceleration + body.alpha.cross(r) + body.omega.cross(wr + T(2) * v) +
                     turned<T>(A, d.acceleration);
  const Vec3<T> w = turned<T>(A, d.omega);
  out.omega = body.omega + w;
  out.alpha = body.alpha + body.omega.cross(w) + turned<T>(A, d.alpha);
}

/// Position and velocity only, for frames that carry nothing but springs and tyres.
template <class T>
void frame_point(const FrameData& f, const Motion<T>& body, const T* y, const T* yd, Motion<T>& out) {
  const Mat3<T>& A = body.rotation;
  Vec3<T> r = f.position.template cast<T>();
  out.velocity = body.velocity;
  if (f.flexible >= 0) {
    r += times(f.X, y);
    out.velocity += turned<T>(A, times(f.X, yd));
  }
  r = turned<T>(A, r);
  out.position = body.position + r;
  out.velocity += body.omega.cross(r);
}

/// Motion of a body from that of one of its frames: the inverse of frame_motion (Lugrís 2008, 2.14, 2.15).
template <class T>
void body_motion(const FrameData& f, const Motion<T>& frame, const T* y, const T* yd, const T* ydd,
                 Motion<T>& out) {
  if (f.flexible < 0) {
    out.rotation = composed<T>(frame.rotation, Mat3<T>(f.rotation.transpose().template cast<T>()));
    const Vec3<T> r = turned<T>(out.rotation, f.position.template cast<T>());
    const Vec3<T> wr = frame.omega.cross(r);
    out.position = frame.position - r;
    out.velocity = frame.velocity - wr;
    out.omega = frame.omega;
    out.acceleration = frame.acceleration - frame.alpha.cross(r) - frame.omega.cross(wr);
    out.alpha = frame.alpha;
    return;
  }
  Deformation<T> d;
  deform(f, y, yd, ydd, d);
  out.rotation = composed<T>(frame.rotation, Mat3<T>(d.rotation.transpose()));
  const Mat3<T>& A = out.rotation;
  const Vec3<T> r = turned<T>(A, d.position), v = turned<T>(A, d.velocity), w = turned<T>(A, d.omega);
  out.omega = frame.omega - w;
  out.alpha = frame.alpha - out.omega.cross(w) - turned<T>(A, d.alpha);
  const Vec3<T> wr = out.omega.cross(r);
  out.position = frame.position - r;
  out.velocity = frame.velocity - wr - v;
  out.acceleration =
      frame.acceleration - out.alpha.cross(r) - out.omega.cross(wr + T(2) * v) - turned<T>(A, d.acceleration);
}

/// Motion of the joint's outboard frame from that of its inboard one, and the joint's motion subspace about
/// the common point. Forward: inboard is frame a, outboard is frame b; reversed: the other way round, with
/// the signs of the motion subspace turned.
template <class T>
void joint_step(const BodyData& b, const Motion<T>& inboard, const T* q, const T* v, const T* a,
                Motion<T>& outboard, Vec3<T>* angular, Vec3<T>* linear) {
  JointMotion<T> m;
  joint_motion<T>(b.joint, q, v, m);
  const int n = b.joint_velocities;
  Vec3<T> w = Vec3<T>::Zero(), u = Vec3<T>::Zero();
  Vec3<T> wd = m.angular_bias, ud = m.linear_bias;
  for (int j = 0; j < n; ++j) {
    w += v[j] * m.angular.col(j);
    u += v[j] * m.linear.col(j);
    wd += a[j] * m.angular.col(j);
    ud += a[j] * m.linear.col(j);
  }
  // A: axes of frame a. r: from origin a to origin b.
  const Mat3<T> A =
      b.reversed ? composed<T>(inboard.rotation, Mat3<T>(m.rotation.transpose())) : inboard.rotation;
  const Vec3<T> r = turned<T>(A, m.displacement);
  w = turned<T>(A, w);
  u = turned<T>(A, u);
  wd = turned<T>(A, wd);
  ud = turned<T>(A, ud);
  Vec3<T> position_b;
  if (!b.reversed) {
    const Vec3<T> wr = inboard.omega.cross(r);
    outboard.rotation = composed<T>(A, m.rotation);
    outboard.position = inboard.position + r;
    outboard.velocity = inboard.velocity + wr + u;
    outboard.omega = inboard.omega + w;
    outboard.acceleration =
        inboard.acceleration + inboard.alpha.cross(r) + inboard.omega.cross(wr + T(2) * u) + ud;
    outboard.alpha = inboard.alpha + inboard.omega.cross(w) + wd;
    position_b = outboard.position;
  } else {
    outboard.rotation = A;
    outboard.position = inboard.position - r;
    outboard.omega = inboard.omega - w;
    outboard.alpha = inboard.alpha - outboard.omega.cross(w) - wd;
    const Vec3<T> wr = outboard.omega.cross(r);
    outboard.velocity = inboard.velocity - wr - u;
    outboard.acceleration =
        inboard.acceleration - outboard.alpha.cross(r) - outboard.omega.cross(wr + T(2) * u) - ud;
    position_b = inboard.position;
  }
  const T sign = b.reversed ? T(-1) : T(1);
  for (int j = 0; j < n; ++j) {
    angular[j] = sign * turned<T>(A, m.angular.col(j));
    linear[j] = sign * turned<T>(A, m.linear.col(j)) + position_b.cross(angular[j]);
  }
}

/// The body's padded modal values copied into `out`.
template <class T>
void copy_modes(const BodyData& b, const T* values, int stride, T* out) {
  for (int k = 0; k < b.modes; ++k) out[k] = values[k];
  for (int k = b.modes; k < stride; ++k) out[k] = T(0);
}

/// Motion of all bodies and of the dynamic frames (of those that are not `full`, position and velocity) at
/// positions q, velocities v, accelerations a. Writes: bodies, frames, joint_angular, joint_linear.
template <class T>
void kinematics(const Compiled& m, Workspace<T>& w, const T* q, const T* v, const T* a) {
  const Vec3<T> no_gravity = -m.gravity.template cast<T>();
  for (int k = m.first_ground_frame; k < m.last_ground_frame; ++k) {
    Motion<T>& f = w.frames[k];
    f.rotation = m.frames[k].rotation.template cast<T>();
    f.position = m.frames[k].position.template cast<T>() - w.origin;
    f.velocity.setZero();
    f.omega.setZero();
    f.acceleration = no_gravity;
    f.alpha.setZero();
  }
  T* y = w.scratch.data();
  for (std::size_t i = 0; i < m.bodies.size(); ++i) {
    const BodyData& b = m.bodies[i];
    T *yd = y, *ydd = y;
    if (b.modes > 0) {
      const int stride = m.flexible[b.flexible].stride;
      yd = y + stride;
      ydd = yd + stride;
      copy_modes(b, q + b.q + b.joint_positions, stride, y);
      copy_modes(b, v + b.v + b.joint_velocities, stride, yd);
      copy_modes(b, a + b.v + b.joint_velocities, stride, ydd);
      const FlexibleData& flexible = m.flexible[b.flexible];
      extend(flexible, y);
      extend(flexible, y, yd);
      extend(flexible, y, yd, ydd);
    }
    Motion<T> outboard;
    joint_step<T>(b, w.frames[b.inboard_frame], q + b.q, v + b.v, a + b.v, outboard, &w.joint_angular[b.v],
                  &w.joint_linear[b.v]);
    body_motion<T>(m.frames[b.outboard_frame], outboard, y, yd, ydd, w.bodies[i]);
    for (int f = b.first_frame; f < b.last_frame; ++f) {
      if (m.frames[f].full)
        frame_motion<T>(m.frames[f], w.bodies[i], y, yd, ydd, w.frames[f]);
      else
        frame_point<T>(m.frames[f], w.bodies[i], y, yd, w.frames[f]);
    }
  }
}

}  // namespace mimbre::relative
