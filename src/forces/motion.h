#pragma once
#include "math/rotation.h"

/// What both formulations and the force elements share of motions and forces. All vectors are in global axes.
namespace mimbre {

/// Pose and motion of a body frame or a frame on a body.
template <class T>
struct Motion {
  Mat3<T> rotation;      ///< its axes to global axes
  Vec3<T> position;      ///< of its origin, relative to the common point
  Vec3<T> velocity;      ///< of its origin
  Vec3<T> omega;         ///< angular velocity
  Vec3<T> acceleration;  ///< of its origin, minus gravity (the ground accelerates with −g)
  Vec3<T> alpha;         ///< angular acceleration
};

/// Force on a frame's origin and moment, acting on the body.
template <class T>
struct Wrench {
  Vec3<T> force;
  Vec3<T> moment;
};

/// Velocities and angular velocity of b as a sees them, global axes.
template <class T>
void relative_velocity(const Motion<T>& a, const Motion<T>& b, Vec3<T>& d, Vec3<T>& u, Vec3<T>& w) {
  d = b.position - a.position;
  u = b.velocity - a.velocity - a.omega.cross(d);
  w = b.omega - a.omega;
}

}  // namespace mimbre
