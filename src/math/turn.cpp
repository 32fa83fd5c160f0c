#include "math/turn.h"

#include "math/cross_matrix.h"
#include "math/elementary.h"

namespace mimbre {

Eigen::Matrix3d turn_about(const Eigen::Vector3d& axis, double angle) {
  const double c = mimbre::cos(angle), s = mimbre::sin(angle);
  return c * Eigen::Matrix3d::Identity() + s * cross_matrix(axis) + (1 - c) * axis * axis.transpose();
}

Eigen::Matrix3d turn_by(const Eigen::Vector3d& vector) {
  const double angle = vector.stableNorm();
  return angle > 0 ? turn_about(vector / angle, angle) : Eigen::Matrix3d::Identity();
}

}  // namespace mimbre
