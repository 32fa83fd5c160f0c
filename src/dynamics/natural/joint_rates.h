#pragma once
#include "dynamics/natural/covector.h"
#include "forces/relative_motion.h"

/// Joint coordinates as functions of the two frames that a joint joins.
namespace mimbre::natural {

/// Vector of a skew matrix; of others, of their skew part.
template <class T>
Vec3<T> vee(const Mat3<T>& m) {
  return T(0.5) * Vec3<T>(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1));
}

/// Motion of one frame as another sees it.
template <class T>
RelativeMotion<T> relative_motion(const FrameMotion<T>& a, const FrameMotion<T>& b) {
  const Vec3<T> wa = vee<T>(a.axes_velocity * a.axes.transpose()),
                wb = vee<T>(b.axes_velocity * b.axes.transpose()),
                alpha_a = vee<T>(a.axes_acceleration * a.axes.transpose()),
                alpha_b = vee<T>(b.axes_acceleration * b.axes.transpose());
  const Motion<T> here{a.axes, a.position, a.velocity, wa, a.acceleration, alpha_a},
      there{b.axes, b.position, b.velocity, wb, b.acceleration, alpha_b};
  return mimbre::relative_motion<T>(here, there);
}

template <class T>
void joint_rates(spec::JointType type, int velocities, const FrameMotion<T>& a, const FrameMotion<T>& b,
                 const T* q, JointRates<T>& out) {
  mimbre::joint_rates<T>(type, velocities, relative_motion<T>(a, b), q, out);
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
  act_between<T>(m, c.frame_a, c.frame_b, a, b, f, n, on_a, on_b);
}

}  // namespace mimbre::natural
