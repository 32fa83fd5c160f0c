#pragma once
#include <array>

#include "compile/compiled.h"
#include "forces/element.h"
#include "forces/measure_wheel.h"
#include "math/elementary.h"
#include "math/smooth.h"
#include "spec/force_law.h"

/// What there is of a tyre that rolls, besides its vertical force, in the axes of its contact
/// (forces/measure_wheel.h): those of ISO 8855, forces and moments of the road on the wheel.
namespace mimbre {

struct WheelQuantity {
  const char *name, *unit, *meaning;  ///< of the tyre '{}'
};
inline constexpr std::array wheel_quantities{
    WheelQuantity{"longitudinal", "N", "force along the road, forwards, on tyre '{}'"},
    WheelQuantity{"lateral", "N", "force along the road, to the left, on tyre '{}'"},
    WheelQuantity{"overturning", "N m", "moment about forwards on tyre '{}', at its contact"},
    WheelQuantity{"rolling", "N m",
                  "moment about its axis on tyre '{}' besides that of the force along; negative resists"},
    WheelQuantity{"aligning", "N m", "moment about the road's normal on tyre '{}', at its contact"},
    WheelQuantity{"slip", "1", "slip of tyre '{}' over its speed forwards, positive where it drives"},
    WheelQuantity{"slip_angle", "rad", "from forwards to where tyre '{}' goes, positive to the left"},
    WheelQuantity{"camber", "rad", "inclination of tyre '{}' on the road, positive to the right"},
    WheelQuantity{"deflection", "m", "of tyre '{}', along the road's normal"},
};
constexpr int first_wheel_moment = 2, first_wheel_slip = 5;

/// After the forces; `to`: one value for each of these. Slips of slower wheels than what the tyre's law takes
/// for slow are over that speed.
template <class T, class State>
void read_wheel(const Compiled& m, const ElementData& tyre, const State& s, T* to) {
  using mimbre::atan2;
  const auto touches = s.x[wheel::gap] < T(0);
  const T none(0), slow(law_info(tyre.law).slow_speed(m.numbers.data() + tyre.numbers));
  for (int k = wheel::forth; k < s.count; ++k) *to++ = select(touches, T(-s.force[k]), none);
  const T speed = smooth::size(T(s.surroundings[wheel::forward]), slow);
  *to++ = select(touches, T(-s.v[wheel::forth] / speed), none);
  *to++ = select(touches, T(atan2(T(s.v[wheel::across]), speed)), none);
  *to++ = s.surroundings[wheel::camber];
  *to++ = select(touches, T(-s.x[wheel::gap]), none);
}

}  // namespace mimbre
