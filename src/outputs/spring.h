#pragma once
#include "compile/signals/compile_signals.h"
#include "mimbre/channels.h"
#include "outputs/view.h"
#include "spec/output_kind.h"

/// Springs between two points, whose elements come first.
namespace mimbre::outputs {

inline const std::string& spring_name(const Compiled& m, int spring) {
  return m.spec().springs[static_cast<std::size_t>(spring)].name;
}

/// Tension.
struct SpringForce {
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return {o.name, "N", fmt::format("tension of spring '{}'", spring_name(m, o.item))};
  }
  static double value(const OutputView& view, const spec::Output& o) { return view.element(o.item).force[0]; }
  static constexpr OutputInfo info{.name = "spring_force",
                                   .of = OutputInfo::Of::spring,
                                   .needs = OutputInfo::Needs::forces,
                                   .describe = describe,
                                   .value = value};
};

struct SpringLength {
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return {o.name, "m", fmt::format("length of spring '{}'", spring_name(m, o.item))};
  }
  static double value(const OutputView& view, const spec::Output& o) { return view.element(o.item).x[0]; }
  static void place(const SensorPlaces&, const spec::Output& o, SensorData& d) { d.element = o.item; }
  template <class T>
  static T seen(const SensorData& d, const SensorView<T>& view) {
    return view.measure(d.element, d.component) + d.offset;
  }
  static constexpr OutputInfo info{.name = "spring_length",
                                   .of = OutputInfo::Of::spring,
                                   .needs = OutputInfo::Needs::forces,
                                   .describe = describe,
                                   .value = value,
                                   .place_sensor = place};
};

}  // namespace mimbre::outputs
