#pragma once
#include "compile/signals/compile_signals.h"
#include "mimbre/channels.h"
#include "mimbre/reduced_body.h"
#include "outputs/driven_sensor.h"
#include "outputs/view.h"
#include "spec/output_kind.h"

namespace mimbre::outputs {

/// Of a flexible body, by the modes that its user gave.
struct ModalAmplitude {
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return {o.name, "1",
            fmt::format("amplitude {} of '{}'", o.component,
                        m.spec().bodies[static_cast<std::size_t>(o.item)].name)};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    const spec::Body& body = view.spec().bodies[static_cast<std::size_t>(o.item)];
    return body.flexible ? body.flexible->user_from_modal.row(o.component).dot(view.amplitudes(o.item)) : 0;
  }
  static void place(const SensorPlaces& places, const spec::Output& o, SensorData& d) {
    d.body = places.compiled.body_of_spec[o.item];
    refuse_driven(places, o, d.body);
    if (const auto& body = places.compiled.spec().bodies[static_cast<std::size_t>(o.item)].flexible) {
      const Eigen::RowVectorXd row = body->user_from_modal.row(o.component);
      d.shapes.assign(row.data(), row.data() + row.size());
    }
  }
  template <class T>
  static T seen(const SensorData& d, const SensorView<T>& view) {
    return seen_amplitudes(d, view);
  }
  static constexpr OutputInfo info{.name = "modal_amplitude",
                                   .of = OutputInfo::Of::body,
                                   .modes = true,
                                   .describe = describe,
                                   .value = value,
                                   .place_sensor = place};
};

}  // namespace mimbre::outputs
