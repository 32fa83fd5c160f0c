#pragma once
#include <cmath>

#include "forces/element.h"

/// Springs and dampers on a length or a joint coordinate x: elastic(x) + damping(ẋ) + general(x, ẋ, …).
namespace mimbre::forces {

namespace spring {
constexpr int elastic = 0, damping = 1;  ///< among the law's functions

inline double general(const LawContext<double>& c, double x, double v) {
  const LawData* law = c.formula();
  if (!law) return 0;
  std::array<double, Formula::most_variables> values;
  gather<double>(*law, {x, v}, c.signals, values);
  return law->formula.value(values.data());
}
}  // namespace spring

inline void spring_law(const LawContext<double>& c, ElementState<double>& s) {
  const double x = s.x[0], v = s.v[0];
  const auto [pull, stiffness] = c.function(spring::elastic).tangent(x);
  const auto [resistance, damping] = c.function(spring::damping).tangent(v);
  s.force[0] = pull + resistance;
  s.stiffness[0] = stiffness;
  s.damping[0] = damping;
  if (const LawData* law = c.formula()) {
    std::array<double, Formula::most_variables> values;
    gather<double>(*law, {x, v}, c.signals, values);
    s.force[0] += law->formula.value(values.data());
    const auto [k, d] = law->formula.derivatives(values.data());
    s.stiffness[0] += k;
    s.damping[0] += d;
  }
}

/// The potential is zero at the assembled length; of the general law what it is at rest works like a load and
/// the rest is a damper's.
inline void spring_energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
  const Function& elastic = c.function(spring::elastic);
  const double start =
      c.element.measure == Measure::distance ? elastic.antiderivative(c.element.reference) : 0;
  e.stored = elastic.antiderivative(s.x[0]) - start;
  // It may be undefined at rest.
  const double whole = spring::general(c, s.x[0], s.v[0]), at_rest = spring::general(c, s.x[0], 0);
  e.working[0] = std::isfinite(at_rest) ? at_rest : 0;
  e.dissipating[0] = c.function(spring::damping).value(s.v[0]) + whole - e.working[0];
}

}  // namespace mimbre::forces
