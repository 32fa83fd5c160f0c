#pragma once
#include "mimbre/diagnostics.h"
#include "outputs/driven_sensor.h"
#include "outputs/frame_motion.h"
#include "spec/check/checked_item.h"

/// How far a frame is from where it is undeformed, along a direction.
namespace mimbre::outputs {

inline void check_direction(const spec::Model&, const checks::CheckedItem& item, const spec::Output& o) {
  if (item.finite("direction", o.direction) && o.direction.isZero(0))
    item.error("direction has no length; give a vector such as (0, 0, 1)");
}

/// Against the frame's body: `direction` is in body axes.
struct Deflection {
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return {o.name, "m", fmt::format("deflection of '{}'", frame_name(m, o.item))};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    const FrameData& f = view.model.frames[view.model.frame_of_spec[o.item]];
    if (f.flexible < 0 && !f.bends) return 0;
    return o.direction.dot(view.deflection(o.item));
  }
  static void place(const SensorPlaces& places, const spec::Output& o, SensorData& d) {
    const Compiled& c = places.compiled;
    const FrameData& f = c.frames[c.frame_of_spec[o.item]];
    d.body = f.body;
    if (f.flexible < 0 && !f.bends) return;
    refuse_driven(places, o, f.body);
    if (!c.flexible[c.bodies[f.body].flexible].products.empty())
      throw InputError(o.mark,
                       fmt::format("the deflection '{}' is that of a body whose modes bend in second order; "
                                   "see it at instants, by a signal with `every: 0.01`",
                                   o.name));
    const Eigen::RowVectorXd row = o.direction.transpose() * f.X.matrix();
    d.shapes.assign(row.data(), row.data() + c.bodies[f.body].modes);
  }
  template <class T>
  static T seen(const SensorData& d, const SensorView<T>& view) {
    return seen_amplitudes(d, view);
  }
  static constexpr OutputInfo info{.name = "deflection",
                                   .of = OutputInfo::Of::frame,
                                   .along = true,
                                   .seen_from_elsewhere = "displacement",
                                   .check = check_direction,
                                   .describe = describe,
                                   .value = value,
                                   .place_sensor = place};
};

/// As another frame sees it: `direction` (axes of `reference`) · place + offset.
struct Displacement {
  template <class T, class Direction>
  static T along(const Direction& direction, const Motion<T>& reference, const Motion<T>& here,
                 double offset) {
    return direction.dot(reference.rotation.transpose() * (here.position - reference.position)) + offset;
  }
  static void check(const spec::Model& model, const checks::CheckedItem& item, const spec::Output& o) {
    item.index("reference", o.reference, model.frames.size(), "frames");
    check_direction(model, item, o);
  }
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return {o.name, "m",
            fmt::format("displacement of '{}' in the axes of '{}'", frame_name(m, o.item),
                        frame_name(m, o.reference))};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return along(o.direction, view.motion(o.reference), view.motion(o.item), o.offset);
  }
  static void place(const SensorPlaces& places, const spec::Output& o, SensorData& d) {
    place_at_frame(places, o, d);
    d.reference = places.compiled.frame_of_spec[o.reference];
  }
  template <class T>
  static T seen(const SensorData& d, const SensorView<T>& view) {
    return along(d.direction.template cast<T>(), view.motion(d.reference), view.motion(d.frame), d.offset);
  }
  static constexpr OutputInfo info{.name = "displacement",
                                   .of = OutputInfo::Of::frame,
                                   .words = axis_words,
                                   .reference = true,
                                   .check = check,
                                   .describe = describe,
                                   .value = value,
                                   .place_sensor = place};
};

}  // namespace mimbre::outputs
