#pragma once
#include "compile/compiled.h"
#include "forces/element.h"
#include "forces/measure_wheel.h"
#include "forces/tyre.h"

namespace mimbre {

/// Of a tyre of either kind, m: its radius, and how far it is from the road; below 0: pressed in.
inline double tyre_radius(const Compiled& m, const ElementData& tyre) {
  return tyre.measure == Measure::wheel ? tyre.radius : m.numbers[tyre.numbers + forces::tyre::radius];
}
inline double tyre_gap(const Compiled& m, const ElementData& tyre, const ElementState<const double>& s) {
  return tyre.measure == Measure::wheel ? s.x[wheel::gap] : s.x[0] - tyre_radius(m, tyre);
}

}  // namespace mimbre
