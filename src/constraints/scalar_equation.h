#pragma once
#include "joints/rates.h"

namespace mimbre {

/// One equation between two frames, Φ = `value`, with what its derivatives consist of:
///
///     Φ̇ = linear · u + angular · ω         u, ω: velocity of b's origin and angular velocity as a sees them
///     Φ̈ = linear · u̇ + angular · ω̇ + bias
///
/// All in a's axes. A multiplier μ acts on b at its origin with the force −μ linear and the moment −μ
/// angular.
template <class T>
struct ScalarEquation {
  T value = T(0);
  Vec3<T> linear = Vec3<T>::Zero(), angular = Vec3<T>::Zero();
  T bias = T(0);

  T rate(const RelativeMotion<T>& r) const { return linear.dot(r.velocity) + angular.dot(r.omega); }
  T second(const RelativeMotion<T>& r) const {
    return linear.dot(r.acceleration) + angular.dot(r.alpha) + bias;
  }
};

template <class T>
ScalarEquation<T> operator-(const ScalarEquation<T>& x, const ScalarEquation<T>& y) {
  return {x.value - y.value, x.linear - y.linear, x.angular - y.angular, x.bias - y.bias};
}
template <class T>
ScalarEquation<T> operator*(const T& factor, const ScalarEquation<T>& e) {
  return {factor * e.value, factor * e.linear, factor * e.angular, factor * e.bias};
}

}  // namespace mimbre
