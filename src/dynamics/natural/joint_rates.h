#pragma once
#include "dynamics/natural/covector.h"
#include "joints/kernels.h"

/// Joint coordinates as functions of the two frames that a joint joins.
namespace mimbre::natural {

/// Vector of a skew matrix; of others, of their skew part.
template <class T>
Vec3<T> vee(const Mat3<T>& m) {
  return T(0.5) * Vec3<T>(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1));
}

/// Rates and second derivatives of a joint's velocity coordinates; q: its positions.
template <class T>
struct JointRates {
  JointMotion<T> motion;
  T v[6], a[6];
};

template <class T>
void joint_rates(spec::JointType type, int velocities, const FrameMotion<T>& a, const FrameMotion<T>& b,
                 const T* q, JointRates<T>& out) {
  const Vec3<T> wa = vee<T>(a.axes_velocity * a.axes.transpose()),
                wb = vee<T>(b.axes_velocity * b.axes.transpose()),
                alpha_a = vee<T>(a.axes_acceleration * a.axes.transpose()),
                alpha_b = vee<T>(b.axes_acceleration * b.axes.transpose());
  const Mat3<T> At = a.axes.transpose();
  const Vec3<T> d = b.position - a.position;
  const Vec3<T> u = b.velocity - a.velocity - wa.cross(d), w = wb - wa;
  // Their derivatives as seen from frame a.
  const Vec3<T> u1 = At *
                     (b.acceleration - a.acceleration - alpha_a.cross(d) - wa.cross(wa.cross(d) + T(2) * u)),
                w1 = At * (alpha_b - alpha_a - wa.cross(w));
  const Vec3<T> u0 = At * u, w0 = At * w;
  const T rest[6] = {T(0), T(0), T(0), T(0), T(0), T(0)};
  joint_motion<T>(type, q, rest, out.motion);
  // The columns of every joint type are orthonormal.
  for (int k = 0; k < velocities; ++k)
    out.v[k] = out.motion.angular.col(k).dot(w0) + out.motion.linear.col(k).dot(u0);
  joint_motion<T>(type, q, out.v, out.motion);
  for (int k = 0; k < velocities; ++k)
    out.a[k] = out.motion.angular.col(k).dot(w1 - out.motion.angular_bias) +
               out.motion.linear.col(k).dot(u1 - out.motion.linear_bias);
}

/// `force` on one coordinate of a joint: a wrench between the frames.
template <class T>
void act_on_coordinate(const Compiled& m, const JointCoordinate& c, const FrameMotion<T>& a,
                       const FrameMotion<T>& b, const T* q, int coordinate, const T& force,
                       const Covector<T>& on_a, const Covector<T>& on_b) {
  JointMotion<T> motion;
  const T rest[6] = {T(0), T(0), T(0), T(0), T(0), T(0)};
  joint_motion<T>(m.bodies[c.body].joint, q, rest, motion);
  const Vec3<T> n = force * (a.axes * motion.angular.col(coordinate)),
                f = force * (a.axes * motion.linear.col(coordinate));
  const Vec3<T> d = b.position - a.position;
  act_on_point<T>(m.frames[c.frame_b], b, f, on_b);
  act_by_moment<T>(m.frames[c.frame_b], b, n, on_b);
  act_on_point<T>(m.frames[c.frame_a], a, -f, on_a);
  act_by_moment<T>(m.frames[c.frame_a], a, -n - d.cross(f), on_a);
}

}  // namespace mimbre::natural
