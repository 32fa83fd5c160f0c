#pragma once
#include <Eigen/Core>

namespace mimbre::model_file {

/// Where an instance of a template stands: mirrored first (diagonal of ±1), then rotated, then moved.
struct Placement {
  Eigen::Vector3d mirror = Eigen::Vector3d::Ones();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  /// Of what stands at `inner` within what stands here: p → here(inner(p)), which is of the same form.
  Placement of(const Placement& inner) const {
    return {mirror.cwiseProduct(inner.mirror),
            rotation * mirror.asDiagonal() * inner.rotation * mirror.asDiagonal(), point(inner.translation)};
  }

  double determinant() const { return mirror.prod(); }
  Eigen::Vector3d point(const Eigen::Vector3d& p) const {
    return rotation * mirror.cwiseProduct(p) + translation;
  }
  /// A force, a direction, a translation axis.
  Eigen::Vector3d vector(const Eigen::Vector3d& v) const { return rotation * mirror.cwiseProduct(v); }
  /// A moment, a rotation axis, an angular velocity (pseudo-vector): a mirror keeps the sense of turning
  /// mirrored.
  Eigen::Vector3d pseudo_vector(const Eigen::Vector3d& v) const { return determinant() * vector(v); }
  /// Axes of a body or frame, M R M: a proper rotation again, in which body-local points are M p̄.
  Eigen::Matrix3d axes(const Eigen::Matrix3d& r) const {
    return rotation * mirror.asDiagonal() * r * mirror.asDiagonal();
  }
  /// A tensor in body axes.
  Eigen::Matrix3d tensor(const Eigen::Matrix3d& j) const {
    return mirror.asDiagonal() * j * mirror.asDiagonal();
  }
};

}  // namespace mimbre::model_file
