#pragma once
#include <Eigen/Core>
#include <array>
#include <bit>
#include <span>
#include <string_view>

#include "mimbre/joint_type.h"

/// The description of a joint type: everything but its motion. Each type is one file of src/joints, which
/// owns both; joints/table.h lists them.
namespace mimbre {

/// One scalar loop closure equation of a cut joint, between frames a and b.
/// distance: a's axis `axis_a` · (origin of b − origin of a) = 0, in a's axes.
/// angle: a's axis `axis_a` · b's axis `axis_b` = 0.
struct LoopClosure {
  enum class Kind { distance, angle } kind;
  int axis_a;
  int axis_b;
};

namespace closure {
constexpr auto D = LoopClosure::Kind::distance;
constexpr auto A = LoopClosure::Kind::angle;
constexpr LoopClosure dx{D, 0, 0}, dy{D, 1, 0}, dz{D, 2, 0};
constexpr LoopClosure xy{A, 0, 1}, yz{A, 1, 2}, zx{A, 2, 0}, xz{A, 0, 2};
}  // namespace closure

struct JointInfo {
  spec::JointType type;
  std::string_view name;            ///< in model files
  std::string_view elsewhere = {};  ///< words that other programs have for it
  int velocities = 0;               ///< number of velocity coordinates
  int positions = 0;                ///< number of position coordinates
  int quaternion = -1;   ///< index of the unit quaternion among the positions, -1 when there is none
  int rotation = 0;      ///< index of its three angular velocities among the velocities
  unsigned lengths = 0;  ///< bit k: velocity coordinate k is a translation (m), otherwise a rotation (rad)
  std::string_view moves = {};  ///< along or about which axis of the frames each coordinate moves: "xyz"
  bool biased = false;  ///< its motion subspace changes in a's axes but by turning with b: angular_bias
  int equations = 0;    ///< equations when cut:
  std::array<LoopClosure, 6> closure = {};

  /// Rigid between flexible bodies, which get all six static modes for it.
  bool all_static_modes = false;

  // Its place and its axes in the model file.
  bool any_place = false;  ///< `at` may be left out: it is at the second body's origin
  std::array<int, 2> given{-1,
                           -1};  ///< which axes (0 for x) `axis` and `axis2` are; -1: there is no such key
  bool implied = false;  ///< it moves along axes that no key gives: they follow the part in which it is
  /// Bit k: in a mirrored part axis k is mirrored as a vector, otherwise as a pseudo-vector, so that all
  /// coordinates mean the same there. Two or none of them.
  unsigned vectors = 0;

  /// It leaves all motions: its position comes first, and it carries no force.
  constexpr bool free() const { return velocities == 6; }
  int axes() const { return given[0] < 0 ? 0 : given[1] < 0 ? 1 : 2; }
  int rotations() const { return velocities - std::popcount(lengths); }
  /// The axis of frame a (0 for x) along or about which velocity coordinate k always moves b; -1: none.
  constexpr int fixed_axis(int k) const {
    const auto at = static_cast<std::size_t>(k);
    return biased || at >= moves.size() ? -1 : moves[at] - 'x';
  }
  bool is_vector(int axis) const { return (vectors >> axis & 1u) != 0; }
};

/// By type: they stand in its order.
extern const JointInfo* const* const joint_infos;
/// All of them.
std::span<const JointInfo* const> all_joints();

inline const JointInfo& joint_info(spec::JointType type) {
  return *joint_infos[static_cast<std::size_t>(type)];
}
/// Whether there is such a type.
bool is_joint(spec::JointType type);

/// Whether a velocity coordinate of a joint is an angle's.
inline bool is_angle(spec::JointType type, int coordinate) {
  return (joint_info(type).lengths >> coordinate & 1u) == 0;
}

/// Axes of both frames of a joint that has one or two: by unit vectors along those that are given, of which
/// two must be at right angles.
Eigen::Matrix3d joint_axes(const JointInfo& info, const Eigen::Vector3d& axis,
                           const Eigen::Vector3d& second = Eigen::Vector3d::Zero());

}  // namespace mimbre
