#pragma once
#include "math/elementary.h"
#include "outputs/frame_motion.h"

/// Angles of a frame: yaw, pitch, roll (z, y', x''), rad.
namespace mimbre::outputs {

struct Roll {
  template <class T>
  static T angle(const Mat3<T>& r) {
    using mimbre::atan2;
    return atan2(r(2, 1), r(2, 2));
  }
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return {o.name, "rad", fmt::format("roll of '{}'", frame_name(m, o.item))};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return angle(view.motion(o.item).rotation);
  }
  template <class T>
  static T seen(const SensorData& d, const SensorView<T>& view) {
    return angle(view.motion(d.frame).rotation);
  }
  static constexpr OutputInfo info{.name = "roll",
                                   .of = OutputInfo::Of::frame,
                                   .describe = describe,
                                   .value = value,
                                   .place_sensor = place_at_frame};
};

struct Pitch {
  template <class T>
  static T angle(const Mat3<T>& r) {
    using mimbre::atan2, mimbre::hypot;
    return atan2(T(-r(2, 0)), T(hypot(r(2, 1), r(2, 2))));
  }
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return {o.name, "rad", fmt::format("pitch of '{}' (nose down positive)", frame_name(m, o.item))};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return angle(view.motion(o.item).rotation);
  }
  template <class T>
  static T seen(const SensorData& d, const SensorView<T>& view) {
    return angle(view.motion(d.frame).rotation);
  }
  static constexpr OutputInfo info{.name = "pitch",
                                   .of = OutputInfo::Of::frame,
                                   .describe = describe,
                                   .value = value,
                                   .place_sensor = place_at_frame};
};

struct Yaw {
  template <class T>
  static T angle(const Mat3<T>& r) {
    using mimbre::atan2;
    return atan2(r(1, 0), r(0, 0));
  }
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return {o.name, "rad", fmt::format("yaw of '{}'", frame_name(m, o.item))};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return angle(view.motion(o.item).rotation);
  }
  template <class T>
  static T seen(const SensorData& d, const SensorView<T>& view) {
    return angle(view.motion(d.frame).rotation);
  }
  static constexpr OutputInfo info{.name = "yaw",
                                   .of = OutputInfo::Of::frame,
                                   .describe = describe,
                                   .value = value,
                                   .place_sensor = place_at_frame};
};

}  // namespace mimbre::outputs
