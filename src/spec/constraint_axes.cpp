#include "spec/constraint_axes.h"

#include "joints/axes.h"
#include "math/turn.h"

namespace mimbre {

std::pair<Eigen::Matrix3d, Eigen::Matrix3d> constraint_axes(spec::Constraint::Kind kind,
                                                            const Eigen::Vector3d& first,
                                                            const Eigen::Vector3d& second) {
  const Eigen::Matrix3d a = axes_with_z(first);
  if (kind != spec::Constraint::Kind::constant_velocity) return {a, axes_with_z(second)};
  return {a, turn_between(first, second) * a};
}

}  // namespace mimbre
