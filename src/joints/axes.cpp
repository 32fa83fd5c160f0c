#include "joints/axes.h"

#include <Eigen/Geometry>
#include <cmath>

namespace mimbre {

Eigen::Matrix3d axes_with_z(const Eigen::Vector3d& z) {
  // Away from z by construction: the coordinate axis along which z is smallest.
  Eigen::Index smallest = 0;
  z.cwiseAbs().minCoeff(&smallest);
  Eigen::Matrix3d axes;
  axes.col(2) = z.normalized();
  axes.col(0) = Eigen::Vector3d::Unit(smallest).cross(axes.col(2)).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

Eigen::Matrix3d axes_with(const std::vector<std::pair<int, Eigen::Vector3d>>& given) {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  if (given.size() == 2) {
    const auto& [i, a] = given[0];
    const auto& [j, b] = given[1];
    axes.col(i) = a;
    axes.col(j) = (b - a * a.dot(b)).normalized();
    const int k = 3 - i - j;
    axes.col(k) = axes.col((k + 1) % 3).cross(axes.col((k + 2) % 3));
  } else if (given.size() == 1) {
    const auto& [i, a] = given[0];
    const Eigen::Matrix3d any = axes_with_z(a);
    axes.col(i) = a;
    axes.col((i + 1) % 3) = any.col(0);
    axes.col((i + 2) % 3) = any.col(1);
  }
  return axes;
}

bool perpendicular(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return std::abs(a.dot(b)) <= 1e-3; }

}  // namespace mimbre
