#include <algorithm>

#include "constraints/table.h"

namespace mimbre {

std::span<const ConstraintInfo* const> all_constraints() { return constraints::infos; }

const ConstraintInfo& constraint_info(int kind) {
  return *constraints::infos[static_cast<std::size_t>(kind)];
}

int find_constraint(std::string_view name) {
  const auto found = std::find_if(constraints::infos.begin(), constraints::infos.end(),
                                  [&](const ConstraintInfo* info) { return info->name == name; });
  return found == constraints::infos.end() ? -1 : static_cast<int>(found - constraints::infos.begin());
}

ConstraintInfo::Axes constraint_axes(const ConstraintInfo& info, const Eigen::Vector3d& first,
                                     const Eigen::Vector3d& second) {
  if (info.frame_axes) return info.frame_axes(first, second);
  return {axes_with_z(first), axes_with_z(second)};
}

}  // namespace mimbre
