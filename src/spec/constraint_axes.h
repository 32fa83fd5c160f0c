#pragma once
#include <Eigen/Core>
#include <utility>

#include "mimbre/spec.h"

namespace mimbre {

/// Axes of the frames of a constraint, global, by directions of length 1 on its first and on its second side:
/// along their z. Of a constant-velocity joint the second's are the first's, bent with the shafts.
std::pair<Eigen::Matrix3d, Eigen::Matrix3d> constraint_axes(spec::Constraint::Kind kind,
                                                            const Eigen::Vector3d& first,
                                                            const Eigen::Vector3d& second);

/// Whether constraints of the kind have a direction on their first and on their second side.
constexpr bool has_axis(spec::Constraint::Kind kind) {
  return kind != spec::Constraint::Kind::coupling && kind != spec::Constraint::Kind::distance &&
         kind != spec::Constraint::Kind::on_curve;
}
constexpr bool has_second_axis(spec::Constraint::Kind kind) {
  return kind == spec::Constraint::Kind::parallel || kind == spec::Constraint::Kind::perpendicular ||
         kind == spec::Constraint::Kind::constant_velocity;
}

}  // namespace mimbre
