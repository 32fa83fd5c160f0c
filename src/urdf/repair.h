#pragma once
#include <Eigen/Core>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "urdf/joint_inertia.h"

/// Masses and inertias that no matter can have.
namespace mimbre::urdf {

/// The corners of the box around a mesh in its own coordinates; none where its file cannot be read.
using MeshBox = std::function<std::optional<std::pair<Eigen::Vector3d, Eigen::Vector3d>>(const Visual&)>;

/// The nearest inertia that matter can have: the principal second moments of mass, (I₁ + I₂ + I₃)/2 − Iₖ,
/// that are negative or next to nothing become a thousandth of the largest. Unchanged where nothing is wrong.
Eigen::Matrix3d possible_inertia(const Eigen::Matrix3d& inertia);
bool is_possible(const Eigen::Matrix3d& inertia);

/// Gives bodies what they need to move, and lists what was and what is:
/// - inertia by possible_inertia;
/// - mass and inertia of its shapes to a body that moves and has no mass, if it has shapes, or if it could
/// not
///   move otherwise; likewise inertia to a mass that a joint turns about itself.
/// Shapes count as solids of 1000 kg/m³, meshes as the boxes around them with half of that. A body without
/// shapes is a ball of a twentieth of the robot's size and a thousandth of its mass.
/// `first`: the root's number, or 1 where the ground is the root.
std::vector<Diagnostic> repair(const Robot& robot, MergedRobot& merged, bool floating, std::size_t first,
                               const MeshBox& box);

/// Notes of what repair would do; the model is refused or cannot run until then.
std::vector<Diagnostic> faults(const Robot& robot, const MergedRobot& merged, bool floating,
                               std::size_t first);

}  // namespace mimbre::urdf
