#pragma once
#include <Eigen/Core>
#include <utility>
#include <vector>

/// Axes from directions, as people give them.
namespace mimbre {

/// Any right-handed axes with the given z, always the same for the same z.
Eigen::Matrix3d axes_with_z(const Eigen::Vector3d& z);

/// Right-handed axes of which one or two are given, as (0 for x, 1 for y, 2 for z; unit vector). Two must be
/// at right angles but for rounded figures: the first counts. None: those of the outer frame.
Eigen::Matrix3d axes_with(const std::vector<std::pair<int, Eigen::Vector3d>>& given);

/// Whether two unit vectors are at right angles, but for rounded figures.
bool perpendicular(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

}  // namespace mimbre
