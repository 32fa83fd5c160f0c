#include "math/turn.h"

#include <Eigen/Geometry>
#include <cmath>

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

// Not by Eigen::Quaterniond::FromTwoVectors, whose singular values every unit that names it compiles for
// seconds.
Eigen::Matrix3d turn_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d a = from.normalized(), b = to.normalized();
  const double c = b.dot(a);
  if (c < -1 + 1e-12) {
    const Eigen::Vector3d axis = a.unitOrthogonal();
    return 2 * axis * axis.transpose() - Eigen::Matrix3d::Identity();
  }
  const double s = std::sqrt((1 + c) * 2);
  Eigen::Quaterniond q;
  q.vec() = a.cross(b) * (1 / s);
  q.w() = s * 0.5;
  if (c < 0) q.normalize();  // 1 + c has lost digits
  return q.toRotationMatrix();
}

}  // namespace mimbre
