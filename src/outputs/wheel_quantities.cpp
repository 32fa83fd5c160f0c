#include "outputs/wheel_quantities.h"

#include <algorithm>

#include "forces/measure_wheel.h"
#include "math/elementary.h"
#include "math/smooth.h"
#include "spec/force_law.h"

namespace mimbre {
namespace {

/// At which a tyre hardly rolls, m/s: slips of slower wheels are over what its law takes for their speed.
double slow_speed(const Compiled& m, const ElementData& tyre) {
  return law_info(tyre.law).slow_speed(m.numbers.data() + tyre.numbers);
}

}  // namespace

void read_wheel(const Compiled& m, const ElementData& tyre, const ElementState<const double>& s, double* to) {
  const bool touches = s.x[wheel::gap] < 0;
  for (int k = wheel::forth; k < s.count; ++k) *to++ = touches ? -s.force[k] : 0;
  const double speed = smooth::size(s.surroundings[wheel::forward], slow_speed(m, tyre));
  *to++ = touches ? -s.v[wheel::forth] / speed : 0;
  *to++ = touches ? mimbre::atan2(s.v[wheel::across], speed) : 0;
  *to++ = s.surroundings[wheel::camber];
  *to++ = std::max(0.0, -s.x[wheel::gap]);
}

}  // namespace mimbre
