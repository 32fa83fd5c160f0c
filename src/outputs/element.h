#pragma once
#include "compile/element_name.h"
#include "compile/signals/compile_signals.h"
#include "joints/joint_kind.h"
#include "mimbre/channels.h"
#include "outputs/view.h"
#include "spec/check/checked_item.h"
#include "spec/output_kind.h"

/// Force, measure and rate of the model's elements, by components: for programs, not for model files.
namespace mimbre::outputs {

/// What the components of an element are called, and their units: force, measure, rate.
struct ComponentNames {
  std::string name, force, measure, rate;
};
inline ComponentNames component_names(const ElementData& e, int k) {
  if (e.measure == Measure::relative)
    return k < 3 ? ComponentNames{std::string(".") + axis_words[k], "N", "m", "m/s"}
                 : ComponentNames{std::string(".r") + axis_words[k - 3], "N m", "rad", "rad/s"};
  if (e.measure == Measure::velocity) return {std::string(".") + axis_words[k], "N", "m/s", "m/s"};
  const bool turns = e.measure == Measure::coordinate ? is_angle(e.joint, e.local) : e.about;
  return turns ? ComponentNames{"", "N m", "rad", "rad/s"} : ComponentNames{"", "N", "m", "m/s"};
}

inline const ElementData& element_of(const Compiled& m, const spec::Output& o) {
  return m.elements[m.first_other + o.item];
}

inline void check_element(const spec::Model& model, const checks::CheckedItem& item, const spec::Output& o) {
  using On = spec::Element::On;
  const On on = model.elements[static_cast<std::size_t>(o.item)].on;
  item.between("component", o.component, 0, on == On::frames ? 5 : on == On::velocity ? 2 : 0);
}

inline void place_at_element(const SensorPlaces& places, const spec::Output& o, SensorData& d) {
  d.element = places.compiled.first_other + o.item;
}

struct ElementForce {
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    const ElementData& e = element_of(m, o);
    return {o.name, component_names(e, o.component).force, "force of " + element_name(m, e)};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return -view.element(view.model.first_other + o.item).force[o.component];
  }
  static constexpr OutputInfo info{.name = "element_force",
                                   .of = OutputInfo::Of::element,
                                   .in_files = false,
                                   .needs = OutputInfo::Needs::forces,
                                   .check = check_element,
                                   .describe = describe,
                                   .value = value};
};

struct ElementMeasure {
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    const ElementData& e = element_of(m, o);
    return {o.name, component_names(e, o.component).measure, "what " + element_name(m, e) + " measures"};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return view.element(view.model.first_other + o.item).x[o.component];
  }
  template <class T>
  static T seen(const SensorData& d, const SensorView<T>& view) {
    return view.measure(d.element, d.component) + d.offset;
  }
  static constexpr OutputInfo info{.name = "element_measure",
                                   .of = OutputInfo::Of::element,
                                   .in_files = false,
                                   .needs = OutputInfo::Needs::forces,
                                   .check = check_element,
                                   .describe = describe,
                                   .value = value,
                                   .place_sensor = place_at_element};
};

struct ElementRate {
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    const ElementData& e = element_of(m, o);
    return {o.name, component_names(e, o.component).rate, "rate of what " + element_name(m, e) + " measures"};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return view.element(view.model.first_other + o.item).v[o.component];
  }
  static void place(const SensorPlaces& places, const spec::Output& o, SensorData& d) {
    place_at_element(places, o, d);
    d.is_rate = true;
  }
  template <class T>
  static T seen(const SensorData& d, const SensorView<T>& view) {
    return view.rate(d.element, d.component);
  }
  static constexpr OutputInfo info{.name = "element_rate",
                                   .of = OutputInfo::Of::element,
                                   .in_files = false,
                                   .needs = OutputInfo::Needs::forces,
                                   .check = check_element,
                                   .describe = describe,
                                   .value = value,
                                   .place_sensor = place};
};

}  // namespace mimbre::outputs
