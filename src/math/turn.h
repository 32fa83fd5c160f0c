#pragma once
#include <Eigen/Core>

namespace mimbre {

/// Rotation matrix of a turn by `angle`, rad, about the unit vector `axis` (Rodrigues' formula), by the
/// project's own sine and cosine: the same bits on every machine.
Eigen::Matrix3d turn_about(const Eigen::Vector3d& axis, double angle);

/// The same of a rotation vector: axis times angle, rad. The zero vector gives the identity.
Eigen::Matrix3d turn_by(const Eigen::Vector3d& vector);

/// The least turn that takes the direction of `from` to that of `to`; neither is zero. Of opposite ones a
/// half turn about an axis across them, always the same for the same `from`.
Eigen::Matrix3d turn_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace mimbre
