#pragma once
#include <algorithm>

#include "compile/signals/compile_signals.h"
#include "joints/joint_kind.h"
#include "mimbre/channels.h"
#include "outputs/view.h"
#include "spec/output_kind.h"

/// A joint's coordinates that are numbers, their rates and accelerations.
namespace mimbre::outputs {

inline const spec::Joint& joint_of(const Compiled& m, int joint) {
  return m.spec().joints[static_cast<std::size_t>(joint)];
}

/// What says the same as the value of a joint's position: angles of cut joints are within ±π.
inline ChannelInfo::Alike alike_position(const Compiled& m, int joint, int position) {
  const JointInfo& info = joint_info(joint_of(m, joint).type);
  if (info.quaternion >= 0 && position >= info.quaternion && position < info.quaternion + 4)
    return ChannelInfo::Alike::sign;
  const bool cut = std::none_of(m.bodies.begin(), m.bodies.end(),
                                [&](const BodyData& b) { return b.joint_spec == joint; });
  return cut && is_angle(info.type, position) ? ChannelInfo::Alike::turns : ChannelInfo::Alike::value;
}

inline constexpr std::string_view no_coordinate = "has no scalar coordinate";

struct JointPosition {
  /// Those before a quaternion.
  static int count(const JointInfo& joint) {
    return joint.quaternion < 0 ? joint.velocities : joint.quaternion;
  }
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    const spec::Joint& joint = joint_of(m, o.item);
    ChannelInfo info{o.name, is_angle(joint.type, o.component) ? "rad" : "m",
                     fmt::format("coordinate {} of joint '{}'", o.component, joint.name)};
    info.alike = alike_position(m, o.item, o.component);
    return info;
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return view.coordinates(o.item).positions[static_cast<std::size_t>(o.component)] + o.offset;
  }
  static void place(const SensorPlaces& places, const spec::Output& o, SensorData& d) {
    d.component = 0;
    d.element = places.of_coordinate(o.item, o.component);
  }
  template <class T>
  static T seen(const SensorData& d, const SensorView<T>& view) {
    return view.measure(d.element, d.component) + d.offset;
  }
  static constexpr OutputInfo info{.name = "joint",
                                   .of = OutputInfo::Of::joint,
                                   .count = count,
                                   .without = no_coordinate,
                                   .offset = true,
                                   .describe = describe,
                                   .value = value,
                                   .place_sensor = place};
};

struct JointVelocity {
  static int count(const JointInfo& joint) { return joint.velocities; }
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    const spec::Joint& joint = joint_of(m, o.item);
    return {o.name, is_angle(joint.type, o.component) ? "rad/s" : "m/s",
            fmt::format("rate of coordinate {} of joint '{}'", o.component, joint.name)};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return view.coordinates(o.item).rates[static_cast<std::size_t>(o.component)];
  }
  static void place(const SensorPlaces& places, const spec::Output& o, SensorData& d) {
    d.component = 0;
    d.element = places.of_coordinate(o.item, o.component);
    d.is_rate = true;
  }
  template <class T>
  static T seen(const SensorData& d, const SensorView<T>& view) {
    return view.rate(d.element, d.component);
  }
  static constexpr OutputInfo info{.name = "joint_velocity",
                                   .of = OutputInfo::Of::joint,
                                   .count = count,
                                   .without = no_coordinate,
                                   .describe = describe,
                                   .value = value,
                                   .place_sensor = place};
};

struct JointAcceleration {
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    const spec::Joint& joint = joint_of(m, o.item);
    return {o.name, is_angle(joint.type, o.component) ? "rad/s²" : "m/s²",
            fmt::format("acceleration of coordinate {} of joint '{}'", o.component, joint.name)};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return view.coordinates(o.item).accelerations[static_cast<std::size_t>(o.component)];
  }
  static constexpr OutputInfo info{.name = "joint_acceleration",
                                   .of = OutputInfo::Of::joint,
                                   .count = JointVelocity::count,
                                   .without = no_coordinate,
                                   .describe = describe,
                                   .value = value};
};

}  // namespace mimbre::outputs
