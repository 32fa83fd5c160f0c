#include "simulation/wheel_channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "forces/measure_wheel.h"

namespace mimbre {
namespace {

/// m/s: slips of a wheel that is slower are those at this speed.
constexpr double slowest = 0.1;

struct WheelChannel {
  const char *name, *unit, *meaning;
};
constexpr WheelChannel channels[] = {
    {"longitudinal", "N", "force along the road, forwards, on tyre '{}'"},
    {"lateral", "N", "force along the road, to the left, on tyre '{}'"},
    {"overturning", "N m", "moment about forwards on tyre '{}', at its contact"},
    {"rolling", "N m",
     "moment about its axis on tyre '{}' besides that of the force along; negative resists"},
    {"aligning", "N m", "moment about the road's normal on tyre '{}', at its contact"},
    {"slip", "1", "slip of tyre '{}' over its speed forwards, positive where it drives"},
    {"slip_angle", "rad", "from forwards to where tyre '{}' goes, positive to the left"},
    {"camber", "rad", "inclination of tyre '{}' on the road, positive to the right"},
    {"deflection", "m", "of tyre '{}', along the road's normal"},
};

}  // namespace

void add_wheel_info(const std::string& tyre, std::vector<ChannelInfo>& info) {
  for (const WheelChannel& c : channels)
    info.push_back(
        {fmt::format("tyre.{}.{}", tyre, c.name), c.unit, fmt::format(fmt::runtime(c.meaning), tyre)});
}

void read_wheel(const ElementState<const double>& s, double* to) {
  const bool touches = s.x[wheel::gap] < 0;
  for (int k = wheel::forth; k < s.count; ++k) *to++ = touches ? -s.force[k] : 0;
  const double speed = std::max(std::abs(s.surroundings[wheel::forward]), slowest);
  *to++ = touches ? -s.v[wheel::forth] / speed : 0;
  *to++ = touches ? std::atan2(s.v[wheel::across], speed) : 0;
  *to++ = s.surroundings[wheel::camber];
  *to++ = std::max(0.0, -s.x[wheel::gap]);
}

}  // namespace mimbre
