#pragma once
#include "compile/signals/compile_signals.h"
#include "mimbre/channels.h"
#include "outputs/view.h"
#include "spec/output_kind.h"

/// Place and motion of a frame.
namespace mimbre::outputs {

inline const std::string& frame_name(const Compiled& m, int frame) {
  return m.spec().frames[static_cast<std::size_t>(frame)].name;
}

/// Signals see it by the frame's motion.
inline void place_at_frame(const SensorPlaces& places, const spec::Output& o, SensorData& d) {
  d.frame = places.compiled.frame_of_spec[o.item];
}

struct Position {
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return {o.name, "m", fmt::format("global {} of '{}'", axis_words[o.component], frame_name(m, o.item))};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return view.motion(o.item).position[o.component] + view.origin()[o.component];
  }
  template <class T>
  static T seen(const SensorData& d, const SensorView<T>& view) {
    return view.motion(d.frame).position[d.component] + view.origin()[d.component];
  }
  static constexpr OutputInfo info{.name = "position",
                                   .of = OutputInfo::Of::frame,
                                   .words = axis_words,
                                   .describe = describe,
                                   .value = value,
                                   .place_sensor = place_at_frame};
};

struct Velocity {
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return {o.name, "m/s",
            fmt::format("global {} velocity of '{}'", axis_words[o.component], frame_name(m, o.item))};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return view.motion(o.item).velocity[o.component];
  }
  template <class T>
  static T seen(const SensorData& d, const SensorView<T>& view) {
    return view.motion(d.frame).velocity[d.component];
  }
  static constexpr OutputInfo info{.name = "velocity",
                                   .of = OutputInfo::Of::frame,
                                   .words = axis_words,
                                   .describe = describe,
                                   .value = value,
                                   .place_sensor = place_at_frame};
};

/// Gravity is no part of it.
struct Acceleration {
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return {o.name, "m/s²",
            fmt::format("global {} acceleration of '{}'", axis_words[o.component], frame_name(m, o.item))};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return view.motion(o.item).acceleration[o.component] + view.model.gravity[o.component];
  }
  static constexpr OutputInfo info{.name = "acceleration",
                                   .of = OutputInfo::Of::frame,
                                   .words = axis_words,
                                   .describe = describe,
                                   .value = value};
};

/// In global axes, or in the frame's own.
struct AngularVelocity {
  template <class T>
  static T component(const Motion<T>& here, bool own_axes, int component) {
    return (own_axes ? Vec3<T>(here.rotation.transpose() * here.omega) : here.omega)[component];
  }
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return {o.name, "rad/s",
            fmt::format("angular velocity of '{}' about {} of {} axes", frame_name(m, o.item),
                        axis_words[o.component], o.own_axes ? "its own" : "the global")};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return component(view.motion(o.item), o.own_axes, o.component);
  }
  template <class T>
  static T seen(const SensorData& d, const SensorView<T>& view) {
    return component(view.motion(d.frame), d.own_axes, d.component);
  }
  static constexpr OutputInfo info{.name = "angular_velocity",
                                   .of = OutputInfo::Of::frame,
                                   .words = axis_words,
                                   .own_axes = true,
                                   .describe = describe,
                                   .value = value,
                                   .place_sensor = place_at_frame};
};

/// In global axes, or in the frame's own, in which it is the rate of the angular velocity's components, too.
struct AngularAcceleration {
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return {o.name, "rad/s²",
            fmt::format("angular acceleration of '{}' about {} of {} axes", frame_name(m, o.item),
                        axis_words[o.component], o.own_axes ? "its own" : "the global")};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    const Motion<double> here = view.motion(o.item);
    return (o.own_axes ? Vec3d(here.rotation.transpose() * here.alpha) : here.alpha)[o.component];
  }
  static constexpr OutputInfo info{.name = "angular_acceleration",
                                   .of = OutputInfo::Of::frame,
                                   .words = axis_words,
                                   .own_axes = true,
                                   .describe = describe,
                                   .value = value};
};

}  // namespace mimbre::outputs
