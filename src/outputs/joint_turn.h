#pragma once
#include "math/rotation.h"
#include "outputs/joint_coordinates.h"

/// How the second body of a spherical or floating joint is turned against its first.
namespace mimbre::outputs {

inline Quat<double> turn_of(const OutputView& view, int joint) {
  const auto first = static_cast<std::size_t>(joint_info(joint_of(view.model, joint).type).quaternion);
  const auto p = view.coordinates(joint).positions;
  return {p[first], p[first + 1], p[first + 2], p[first + 3]};
}

inline constexpr std::string_view no_quaternion = "has coordinates of its own; see 'joint'";

/// Rotation vector in the first body's axes, of an angle up to π.
struct JointRotation {
  static int count(const JointInfo& joint) { return joint.quaternion < 0 ? 0 : 3; }
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return {o.name, "rad",
            fmt::format(
                "rotation vector of joint '{}', its second body against the first, {} of the first's axes",
                joint_of(m, o.item).name, axis_words[o.component])};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return quaternion_log<double>(turn_of(view, o.item))[o.component];
  }
  static constexpr OutputInfo info{.name = "joint_rotation",
                                   .of = OutputInfo::Of::joint,
                                   .words = axis_words,
                                   .count = count,
                                   .without = no_quaternion,
                                   .describe = describe,
                                   .value = value};
};

/// Unit quaternion, the second body's axes to the first's.
struct JointQuaternion {
  static constexpr const char* words[] = {"w", "x", "y", "z"};
  static int count(const JointInfo& joint) { return joint.quaternion < 0 ? 0 : 4; }
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    ChannelInfo info{o.name, "1",
                     fmt::format("quaternion {} of joint '{}', its second body's axes to the first's",
                                 words[o.component], joint_of(m, o.item).name)};
    info.alike = ChannelInfo::Alike::sign;
    return info;
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return turn_of(view, o.item)[o.component];
  }
  static constexpr OutputInfo info{.name = "joint_quaternion",
                                   .of = OutputInfo::Of::joint,
                                   .words = words,
                                   .count = count,
                                   .without = no_quaternion,
                                   .describe = describe,
                                   .value = value};
};

}  // namespace mimbre::outputs
