#include "simulation/observe/wheel_channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "forces/measure_wheel.h"
#include "math/elementary.h"
#include "math/smooth.h"
#include "spec/force_law.h"

namespace mimbre {
namespace {

using Measured = spec::Output::Kind;

/// At which a tyre hardly rolls, m/s: slips of slower wheels are over what its law takes for their speed.
double slow_speed(const Compiled& m, const ElementData& tyre) {
  return law_info(tyre.law).slow_speed(m.numbers.data() + tyre.numbers);
}

struct WheelChannel {
  const char *name, *unit, *meaning;
};
constexpr std::array channels{
    WheelChannel{"longitudinal", "N", "force along the road, forwards, on tyre '{}'"},
    WheelChannel{"lateral", "N", "force along the road, to the left, on tyre '{}'"},
    WheelChannel{"overturning", "N m", "moment about forwards on tyre '{}', at its contact"},
    WheelChannel{"rolling", "N m",
                 "moment about its axis on tyre '{}' besides that of the force along; negative resists"},
    WheelChannel{"aligning", "N m", "moment about the road's normal on tyre '{}', at its contact"},
    WheelChannel{"slip", "1", "slip of tyre '{}' over its speed forwards, positive where it drives"},
    WheelChannel{"slip_angle", "rad", "from forwards to where tyre '{}' goes, positive to the left"},
    WheelChannel{"camber", "rad", "inclination of tyre '{}' on the road, positive to the right"},
    WheelChannel{"deflection", "m", "of tyre '{}', along the road's normal"},
};

/// Which of these an output shows; -1: the vertical force.
int channel_of(const spec::Output& o) {
  constexpr int moments = 2, slip = 5;
  switch (o.kind) {
    case Measured::tyre_moment:
      return moments + o.component;
    case Measured::tyre_slip:
      return slip;
    case Measured::tyre_slip_angle:
      return slip + 1;
    case Measured::tyre_camber:
      return slip + 2;
    case Measured::tyre_deflection:
      return slip + 3;
    default:
      return o.component - 1;
  }
}

std::string meaning(const WheelChannel& c, const std::string& tyre) {
  return fmt::format(fmt::runtime(c.meaning), tyre);
}

}  // namespace

void add_wheel_info(const std::string& tyre, std::vector<ChannelInfo>& info) {
  for (const WheelChannel& c : channels)
    info.push_back({fmt::format("tyre.{}.{}", tyre, c.name), c.unit, meaning(c, tyre)});
}

void read_wheel(const Compiled& m, const ElementData& tyre, const ElementState<const double>& s, double* to) {
  const bool touches = s.x[wheel::gap] < 0;
  for (int k = wheel::forth; k < s.count; ++k) *to++ = touches ? -s.force[k] : 0;
  const double speed = smooth::size(s.surroundings[wheel::forward], slow_speed(m, tyre));
  *to++ = touches ? -s.v[wheel::forth] / speed : 0;
  *to++ = touches ? mimbre::atan2(s.v[wheel::across], speed) : 0;
  *to++ = s.surroundings[wheel::camber];
  *to++ = std::max(0.0, -s.x[wheel::gap]);
}

ChannelInfo wheel_output_info(const std::string& tyre, const spec::Output& output) {
  const int k = channel_of(output);
  if (k < 0) return {output.name, "N", fmt::format("vertical force of tyre '{}'", tyre)};
  const WheelChannel& c = channels[static_cast<std::size_t>(k)];
  return {output.name, c.unit, meaning(c, tyre)};
}

double wheel_output(const Compiled& m, const ElementData& tyre, const spec::Output& output,
                    const ElementState<const double>& s) {
  const int k = channel_of(output);
  if (k < 0) return -s.force[wheel::gap];
  std::array<double, channels.size()> values;
  read_wheel(m, tyre, s, values.data());
  return values[static_cast<std::size_t>(k)];
}

}  // namespace mimbre
