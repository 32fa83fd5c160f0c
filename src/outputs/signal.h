#pragma once
#include "mimbre/channels.h"
#include "outputs/view.h"
#include "spec/output_kind.h"

/// Signals and inputs as outputs of a name of their own: for programs, not for model files.
namespace mimbre::outputs {

struct SignalValue {
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    const spec::Signal& s = m.spec().signals[static_cast<std::size_t>(o.item)];
    return {o.name, s.unit.empty() ? "1" : s.unit, fmt::format("signal '{}'", s.name)};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return view.slot(view.model.signals.slot_of_signal[o.item]);
  }
  static constexpr OutputInfo info{.name = "signal",
                                   .of = OutputInfo::Of::signal,
                                   .in_files = false,
                                   .needs = OutputInfo::Needs::forces,
                                   .describe = describe,
                                   .value = value};
};

struct InputValue {
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    const spec::Input& i = m.spec().inputs[static_cast<std::size_t>(o.item)];
    return {o.name, i.unit.empty() ? "1" : i.unit, fmt::format("input '{}'", i.name)};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    return view.slot(view.model.signals.slot_of_input[o.item]);
  }
  static constexpr OutputInfo info{.name = "input",
                                   .of = OutputInfo::Of::input,
                                   .in_files = false,
                                   .needs = OutputInfo::Needs::forces,
                                   .describe = describe,
                                   .value = value};
};

}  // namespace mimbre::outputs
