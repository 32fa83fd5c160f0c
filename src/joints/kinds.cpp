#include "joints/axes.h"
#include "joints/table.h"

namespace mimbre {

constinit const JointInfo* const* const joint_infos = joints::infos.data();

std::span<const JointInfo* const> all_joints() { return joints::infos; }

bool is_joint(spec::JointType type) { return static_cast<std::size_t>(type) < joints::infos.size(); }

Eigen::Matrix3d joint_axes(const JointInfo& info, const Eigen::Vector3d& axis,
                           const Eigen::Vector3d& second) {
  if (info.axes() < 2) return axes_with_z(axis);
  return axes_with({{info.given[0], axis}, {info.given[1], second}});
}

}  // namespace mimbre
