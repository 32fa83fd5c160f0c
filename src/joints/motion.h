#pragma once
#include "math/elementary.h"
#include "math/rotation.h"

namespace mimbre {

/// What a joint contributes to kinematics: the motion of its frame b relative to its frame a, in a's axes.
/// Its motion subspace (Roberson and Wittenburg's joint Jacobian): column j is the angular velocity
/// `angular.col(j)` and the velocity of b's origin `linear.col(j)` per unit velocity coordinate j; one of the
/// two is zero, as JointInfo::lengths says. The bias, or velocity-product acceleration, is Σ_j ċol_j v_j, the
/// derivative taken in a's axes; no joint has a linear one.
template <class T>
struct JointMotion {
  Mat3<T> rotation;  ///< b's axes to a's axes
  Vec3<T> displacement;
  Eigen::Matrix<T, 3, 6> angular;
  Eigen::Matrix<T, 3, 6> linear;
  Vec3<T> angular_bias;

  void reset() {
    rotation.setIdentity();
    displacement.setZero();
    angular.setZero();
    linear.setZero();
    angular_bias.setZero();
  }
};

/// Rotation about z.
template <class T>
Mat3<T> rotation_z(const T& angle) {
  using mimbre::cos, mimbre::sin;
  const T c = cos(angle), s = sin(angle);
  Mat3<T> r;
  r << c, -s, T(0), s, c, T(0), T(0), T(0), T(1);
  return r;
}

/// Angle of a rotation about z, within ±π.
template <class T>
T turn_about_z(const Mat3<T>& rotation) {
  using mimbre::atan2;
  return atan2(rotation(1, 0), rotation(0, 0));
}

}  // namespace mimbre
