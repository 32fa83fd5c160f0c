#pragma once
#include "dynamics/amplitudes.h"
#include "dynamics/deformation.h"
#include "dynamics/natural/workspace.h"

/// Motion of bodies and frames, linear in the variables.
namespace mimbre::natural {

/// Σ_k base(s, k) x_k for the body's four base vectors.
template <class T>
void combine(const Body& b, const std::vector<Vec3<T>>& x, int count, Base<T>& out) {
  out.setZero();
  for (int k = 0; k < count; ++k) {
    const Vec3<T>& v = x[b.variables[k]];
    for (int s = 0; s < 4; ++s) out.col(s) += T(b.base(s, k)) * v;
  }
}

/// Motion of a frame. y, ẏ, ÿ: the body's padded amplitudes. Not `all`: position and velocity only.
template <class T>
void frame_motion(const FrameData& f, const BaseMotion<T>& b, const T* y, const T* yd, const T* ydd, bool all,
                  FrameMotion<T>& out) {
  const auto A = b.position.template rightCols<3>(), Ad = b.velocity.template rightCols<3>(),
             Add = b.acceleration.template rightCols<3>();
  if (f.flexible < 0) {
    out.place = f.position.template cast<T>();
    out.position = b.position.col(0) + A * out.place;
    out.velocity = b.velocity.col(0) + Ad * out.place;
    if (!all) return;
    out.acceleration = b.acceleration.col(0) + Add * out.place;
    out.rotation = f.rotation.template cast<T>();
    out.axes.noalias() = A * out.rotation;
    out.axes_velocity.noalias() = Ad * out.rotation;
    out.axes_acceleration.noalias() = Add * out.rotation;
    return;
  }
  if (!all) {
    out.place = f.position.template cast<T>() + times(f.X, y);
    out.position = b.position.col(0) + A * out.place;
    out.velocity = b.velocity.col(0) + Ad * out.place + A * times(f.X, yd);
    return;
  }
  Deformation<T> d;
  deform(f, y, yd, ydd, d);
  out.place = d.position;
  out.rotation = d.rotation;
  out.position = b.position.col(0) + A * d.position;
  out.velocity = b.velocity.col(0) + Ad * d.position + A * d.velocity;
  out.acceleration = b.acceleration.col(0) + Add * d.position + T(2) * (Ad * d.velocity) + A * d.acceleration;
  // Ė = ω~ E, Ë = (α~ + ω~ω~) E, E the axes in the body.
  const Mat3<T> w = skew<T>(d.omega);
  const Mat3<T> e1 = w * d.rotation;
  const Mat3<T> e2 = skew<T>(d.alpha) * d.rotation + w * e1;
  out.axes.noalias() = A * d.rotation;
  out.axes_velocity.noalias() = Ad * d.rotation + A * e1;
  out.axes_acceleration.noalias() = Add * d.rotation + T(2) * (Ad * e1) + A * e2;
}

template <class T>
FrameMotion<T> ground_frame(const FrameData& f, const Vec3d& origin) {
  FrameMotion<T> out;
  out.position = out.place = (f.position - origin).template cast<T>();
  out.axes = out.rotation = f.rotation.template cast<T>();
  out.velocity.setZero();
  out.acceleration.setZero();
  out.axes_velocity.setZero();
  out.axes_acceleration.setZero();
  return out;
}

/// Any frame, after kinematics().
template <class T>
FrameMotion<T> motion_of(const Compiled& m, const Layout& l, const Workspace<T>& w, int frame) {
  const FrameData& f = m.frames[frame];
  if (f.body < 0) return ground_frame<T>(f, l.origin);
  const int at = l.bodies[f.body].amplitudes;
  FrameMotion<T> out;
  frame_motion<T>(f, w.bodies[f.body], w.y.data() + at, w.yd.data() + at, w.ydd.data() + at, true, out);
  return out;
}

/// Bodies, amplitudes and the frames in use at q, v, a.
template <class T>
void kinematics(const Compiled& m, const Layout& l, Workspace<T>& w, const T* q, const T* v, const T* a) {
  for (int k = 0; k < l.unknown_variables; ++k) {
    w.values[k] = Vec3<T>(q[3 * k], q[3 * k + 1], q[3 * k + 2]);
    w.rates[k] = Vec3<T>(v[3 * k], v[3 * k + 1], v[3 * k + 2]);
    w.seconds[k] = Vec3<T>(a[3 * k], a[3 * k + 1], a[3 * k + 2]);
  }
  for (std::size_t i = 0; i < l.bodies.size(); ++i) {
    const Body& b = l.bodies[i];
    combine(b, w.values, static_cast<int>(b.variables.size()), w.bodies[i].position);
    combine(b, w.rates, b.unknown, w.bodies[i].velocity);
    combine(b, w.seconds, b.unknown, w.bodies[i].acceleration);
    for (int k = 0; k < m.bodies[i].modes; ++k) {
      w.y[b.amplitudes + k] = q[b.q + k];
      w.yd[b.amplitudes + k] = v[b.q + k];
      w.ydd[b.amplitudes + k] = a[b.q + k];
    }
    if (m.bodies[i].modes > 0) {
      const FlexibleData& f = m.flexible[m.bodies[i].flexible];
      extend(f, w.y.data() + b.amplitudes);
      extend(f, w.y.data() + b.amplitudes, w.yd.data() + b.amplitudes);
      extend(f, w.y.data() + b.amplitudes, w.yd.data() + b.amplitudes, w.ydd.data() + b.amplitudes);
    }
    const T *y = w.y.data() + b.amplitudes, *yd = w.yd.data() + b.amplitudes,
            *ydd = w.ydd.data() + b.amplitudes;
    for (int f = m.bodies[i].first_frame; f < m.bodies[i].last_frame; ++f)
      if (l.frame_use[f] > 0)
        frame_motion<T>(m.frames[f], w.bodies[i], y, yd, ydd, l.frame_use[f] > 1, w.frames[f]);
  }
  for (int f : l.late_frames) w.frames[f] = motion_of(m, l, w, f);
}

}  // namespace mimbre::natural
