#pragma once
#include <Eigen/Core>

namespace mimbre {

/// Rotation matrix of a turn by `angle`, rad, about the unit vector `axis` (Rodrigues' formula), by the
/// project's own sine and cosine: the same bits on every machine.
Eigen::Matrix3d turn_about(const Eigen::Vector3d& axis, double angle);

/// The same of a rotation vector: axis times angle, rad. The zero vector gives the identity.
Eigen::Matrix3d turn_by(const Eigen::Vector3d& vector);

}  // namespace mimbre
