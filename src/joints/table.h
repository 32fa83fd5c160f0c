#pragma once
#include <array>
#include <string_view>

#include "mimbre/joint_type.h"

namespace mimbre {

/// One scalar loop closure equation of a cut joint, between frames a and b.
/// distance: a's axis `axis_a` · (origin of b − origin of a) = 0, in a's axes.
/// angle: a's axis `axis_a` · b's axis `axis_b` = 0.
struct LoopClosure {
  enum class Kind { distance, angle } kind;
  int axis_a;
  int axis_b;
};

/// All that the library knows of a joint type besides its motion.
struct JointInfo {
  spec::JointType type;
  std::string_view name;
  int velocities;    ///< number of velocity coordinates
  int positions;     ///< number of position coordinates
  int quaternion;    ///< index of the unit quaternion among the positions, -1 when there is none
  int rotation;      ///< index of its three angular velocities among the velocities
  int equations;     ///< equations when cut
  unsigned lengths;  ///< bit k: velocity coordinate k is a translation (m), otherwise a rotation (rad)
  std::array<LoopClosure, 6> closure;
};

namespace closure {
constexpr auto D = LoopClosure::Kind::distance;
constexpr auto A = LoopClosure::Kind::angle;
constexpr LoopClosure dx{D, 0, 0}, dy{D, 1, 0}, dz{D, 2, 0};
constexpr LoopClosure xy{A, 0, 1}, yz{A, 1, 2}, zx{A, 2, 0}, xz{A, 0, 2};
}  // namespace closure

/// A new joint type is one file with its motion, a row here and a line in joint_motion and joint_coordinates
/// (joints/kernels.h).
// clang-format off
constexpr std::array<JointInfo, 9> joint_table{{
    {spec::JointType::fixed, "fixed", 0, 0, -1, 0, 6, 0b0, {closure::dx, closure::dy, closure::dz, closure::xy, closure::yz, closure::zx}},
    {spec::JointType::bracket, "bracket", 0, 0, -1, 0, 6, 0b0, {closure::dx, closure::dy, closure::dz, closure::xy, closure::yz, closure::zx}},
    {spec::JointType::revolute, "revolute", 1, 1, -1, 0, 5, 0b0, {closure::dx, closure::dy, closure::dz, closure::xz, closure::yz}},
    {spec::JointType::prismatic, "prismatic", 1, 1, -1, 0, 5, 0b1, {closure::dx, closure::dy, closure::xy, closure::yz, closure::zx}},
    {spec::JointType::cylindrical, "cylindrical", 2, 2, -1, 0, 4, 0b10, {closure::dx, closure::dy, closure::xz, closure::yz}},
    {spec::JointType::universal, "universal", 2, 2, -1, 0, 4, 0b0, {closure::dx, closure::dy, closure::dz, closure::xy}},
    {spec::JointType::spherical, "spherical", 3, 4, 0, 0, 3, 0b0, {closure::dx, closure::dy, closure::dz}},
    {spec::JointType::planar, "planar", 3, 3, -1, 0, 3, 0b011, {closure::dz, closure::xz, closure::yz}},
    {spec::JointType::floating, "floating", 6, 7, 3, 3, 0, 0b000111, {}},
}};
// clang-format on

constexpr const JointInfo& joint_info(spec::JointType type) {
  return joint_table[static_cast<std::size_t>(type)];
}

/// Whether a velocity coordinate of a joint is an angle's.
constexpr bool is_angle(spec::JointType type, int coordinate) {
  return (joint_info(type).lengths >> coordinate & 1u) == 0;
}

}  // namespace mimbre
