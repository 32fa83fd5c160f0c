#pragma once
#include "joints/table.h"

/// Joint coordinates as functions of how one frame moves as seen from another.
namespace mimbre {

/// Motion of a frame b as seen from a frame a, in a's axes; derivatives are those that a sees.
template <class T>
struct RelativeMotion {
  Mat3<T> rotation;                              ///< b's axes to a's axes
  Vec3<T> displacement;                          ///< of b's origin
  Vec3<T> velocity, acceleration, omega, alpha;  ///< of the origin, and of the turning
};

/// Rates and second derivatives of a joint's velocity coordinates.
template <class T>
struct JointRates {
  JointMotion<T> motion;
  T v[6], a[6];
};

/// `q`: its positions.
template <class T>
void joint_rates(spec::JointType type, int velocities, const RelativeMotion<T>& r, const T* q,
                 JointRates<T>& out) {
  const T rest[6] = {T(0), T(0), T(0), T(0), T(0), T(0)};
  joint_motion<T>(type, q, rest, out.motion);
  // The columns of every joint type are orthonormal.
  for (int k = 0; k < velocities; ++k)
    out.v[k] = out.motion.angular.col(k).dot(r.omega) + out.motion.linear.col(k).dot(r.velocity);
  joint_motion<T>(type, q, out.v, out.motion);
  for (int k = 0; k < velocities; ++k)
    out.a[k] = out.motion.angular.col(k).dot(r.alpha - out.motion.angular_bias) +
               out.motion.linear.col(k).dot(r.acceleration);
}

}  // namespace mimbre
