#pragma once
#include <array>

#include "compile/compiled.h"
#include "forces/element.h"

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

/// After the forces; `to`: one value for each of these.
void read_wheel(const Compiled& model, const ElementData& tyre, const ElementState<const double>& state,
                double* to);

}  // namespace mimbre
