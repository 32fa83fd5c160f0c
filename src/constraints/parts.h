#pragma once
#include <cmath>
#include <numbers>

#include "constraints/scalar_equation.h"

/// What the equations of constraints consist of.
namespace mimbre::constraints {

/// The component of b's origin along an axis of a.
template <class T>
ScalarEquation<T> along_axis(const RelativeMotion<T>& r, int axis) {
  ScalarEquation<T> e;
  e.value = r.displacement[axis];
  e.linear = Vec3<T>::Unit(axis);
  return e;
}

/// The product of an axis of a and an axis of b, x · z: with ż = ω × z it is (z × x) · ω, and then
/// (z × x) · ω̇ + x · (ω × (ω × z)).
template <class T>
ScalarEquation<T> axes_product(const RelativeMotion<T>& r, int axis_a, int axis_b) {
  ScalarEquation<T> e;
  const Vec3<T> x = Vec3<T>::Unit(axis_a), z = r.rotation.col(axis_b);
  e.value = z[axis_a];
  e.angular = z.cross(x);
  e.bias = r.omega.cross(Vec3<T>(r.omega.cross(z)))[axis_a];
  return e;
}

/// A coordinate of a joint between the frames, whose angle counts turns from `last` on. `known`: its
/// positions where they are known already.
template <class T>
ScalarEquation<T> coordinate(spec::JointType type, int velocities, int local, const RelativeMotion<T>& r,
                             const T* known, const T& last) {
  using std::round;
  T found[7]{};
  if (!known) joint_coordinates<T>(type, r.rotation, r.displacement, found);
  const T* q = known ? known : found;
  JointRates<T> rates;
  joint_rates<T>(type, velocities, r, q, rates);
  ScalarEquation<T> e;
  e.value = q[local];
  if (!known && is_angle(type, local)) {
    constexpr double turn = 2 * std::numbers::pi;
    e.value += T(turn) * T(round((last - q[local]) / turn));
  }
  e.linear = rates.motion.linear.col(local);
  e.angular = rates.motion.angular.col(local);
  e.bias = rates.a[local] - e.linear.dot(r.acceleration) - e.angular.dot(r.alpha);
  return e;
}

}  // namespace mimbre::constraints
