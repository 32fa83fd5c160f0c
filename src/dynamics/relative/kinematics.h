#pragma once
#include "dynamics/amplitudes.h"
#include "dynamics/deformation.h"
#include "dynamics/relative/workspace.h"
#include "joints/table.h"

/// Positions, velocities and accelerations from the root to the leaves.
namespace mimbre::relative {

/// Motion of a frame that modes move, from that of its body. y, ẏ, ÿ: the body's padded amplitudes.
template <class T>
void deformed_motion(const FrameData& f, const Motion<T>& body, const T* y, const T* yd, const T* ydd,
                     Motion<T>& out) {
  const Mat3<T>& A = body.rotation;
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

/// Motion of a frame from that of its body, likewise.
template <class T>
void frame_motion(const FrameData& f, const Motion<T>& body, const T* y, const T* yd, const T* ydd,
                  Motion<T>& out) {
  const Mat3<T>& A = body.rotation;
  if (f.flexible >= 0) return deformed_motion(f, body, y, yd, ydd, out);
  out.rotation = f.aligned ? A : composed<T>(A, Mat3<T>(f.rotation.template cast<T>()));
  out.omega = body.omega;
  out.alpha = body.alpha;
  if (f.central) {
    out.position = body.position;
    out.velocity = body.velocity;
    out.acceleration = body.acceleration;
    return;
  }
  const Vec3<T> r = turned<T>(A, f.position.template cast<T>());
  const Vec3<T> wr = body.omega.cross(r);
  out.position = body.position + r;
  out.velocity = body.velocity + wr;
  out.acceleration = body.acceleration + body.alpha.cross(r) + body.omega.cross(wr);
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
    out.rotation = f.aligned
                       ? frame.rotation
                       : composed<T>(frame.rotation, Mat3<T>(f.rotation.transpose().template cast<T>()));
    out.omega = frame.omega;
    out.alpha = frame.alpha;
    if (f.central) {
      out.position = frame.position;
      out.velocity = frame.velocity;
      out.acceleration = frame.acceleration;
      return;
    }
    const Vec3<T> r = turned<T>(out.rotation, f.position.template cast<T>());
    const Vec3<T> wr = frame.omega.cross(r);
    out.position = frame.position - r;
    out.velocity = frame.velocity - wr;
    out.acceleration = frame.acceleration - frame.alpha.cross(r) - frame.omega.cross(wr);
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
  const auto is_length = [&](int j) { return (b.joint_lengths >> j & 1U) != 0; };
  const T sign = b.reversed ? T(-1) : T(1);
  // A: axes of frame a.
  const Mat3<T> A =
      b.reversed ? composed<T>(inboard.rotation, Mat3<T>(m.rotation.transpose())) : inboard.rotation;
  Vec3<T> w = Vec3<T>::Zero(), wd = Vec3<T>::Zero();  // of b in a: angular velocity and its rate
  Vec3<T> u = Vec3<T>::Zero(), ud = Vec3<T>::Zero();  // velocity of b's origin and its rate
  if (b.joint_biased) wd = turned<T>(A, m.angular_bias);
  for (int j = 0; j < n; ++j) {
    const int axis = b.joint_axes[static_cast<std::size_t>(j)];
    if (is_length(j)) {
      const Vec3<T> column = axis >= 0 ? Vec3<T>(A.col(axis)) : turned<T>(A, m.linear.col(j));
      u += v[j] * column;
      ud += a[j] * column;
      linear[j] = sign * column;
      angular[j].setZero();
    } else {
      const Vec3<T> column = axis >= 0 ? Vec3<T>(A.col(axis)) : turned<T>(A, m.angular.col(j));
      w += v[j] * column;
      wd += a[j] * column;
      angular[j] = sign * column;
    }
  }
  if (!b.reversed) {
    outboard.rotation = composed<T>(A, m.rotation);
    outboard.omega = inboard.omega + w;
    outboard.alpha = inboard.alpha + inboard.omega.cross(w) + wd;
  } else {
    outboard.rotation = A;
    outboard.omega = inboard.omega - w;
    outboard.alpha = inboard.alpha - outboard.omega.cross(w) - wd;
  }
  if (b.joint_lengths == 0) {  // the origins of both frames are one point
    outboard.position = inboard.position;
    outboard.velocity = inboard.velocity;
    outboard.acceleration = inboard.acceleration;
  } else {
    const Vec3<T> r = turned<T>(A, m.displacement);  // from origin a to origin b
    const Motion<T>& of_a = b.reversed ? outboard : inboard;
    const Vec3<T> wr = of_a.omega.cross(r);
    outboard.position = inboard.position + sign * r;
    outboard.velocity = inboard.velocity + sign * (wr + u);
    outboard.acceleration =
        inboard.acceleration + sign * (of_a.alpha.cross(r) + of_a.omega.cross(wr + T(2) * u) + ud);
  }
  const Vec3<T>& position_b = b.reversed ? inboard.position : outboard.position;
  for (int j = 0; j < n; ++j)
    if (!is_length(j)) linear[j] = position_b.cross(angular[j]);
}

/// The body's padded modal values copied into `out`.
template <class T>
void copy_modes(const BodyData& b, const T* values, int stride, T* out) {
  for (int k = 0; k < b.modes; ++k) out[k] = values[k];
  for (int k = b.modes; k < stride; ++k) out[k] = T(0);
}

/// Motion of all bodies and of their dynamic frames (of those that are not `full`, position and velocity) at
/// positions q, velocities v, accelerations a. Writes: bodies, frames, joint_angular, joint_linear. Those of
/// the ground have to be in place.
template <class T>
void kinematics(const Compiled& m, Workspace<T>& w, const T* q, const T* v, const T* a) {
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
