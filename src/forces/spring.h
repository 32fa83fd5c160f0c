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

template <class T>
void spring_law(const LawContext<T>& c, ElementState<T>& s) {
  const T x = s.x[0], v = s.v[0];
  const auto [pull, stiffness] = tangent_at(c.function(spring::elastic), x);
  const auto [resistance, damping] = tangent_at(c.function(spring::damping), v);
  s.force[0] = pull + resistance;
  s.stiffness[0] = stiffness;
  s.damping[0] = damping;
  if (const LawData* law = c.formula()) {
    std::array<T, Formula::most_variables> values;
    gather<T>(*law, {x, v}, c.signals, values);
    s.force[0] += value_at(law->formula, values.data());
    const auto [k, d] = derivatives_at(law->formula, values.data());
    s.stiffness[0] += k;
    s.damping[0] += d;
  }
}

/// The potential is zero at the assembled length; of the general law what it is at rest works like a load and
/// the rest is a damper's.
inline void spring_energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
  const FunctionData& elastic = c.function(spring::elastic);
  const double start =
      c.element.measure == Measure::distance ? elastic.antiderivative(c.element.reference) : 0;
  e.stored = elastic.antiderivative(s.x[0]) - start;
  // It may be undefined at rest.
  const double whole = spring::general(c, s.x[0], s.v[0]), at_rest = spring::general(c, s.x[0], 0);
  e.working[0] = std::isfinite(at_rest) ? at_rest : 0;
  e.dissipating[0] = c.function(spring::damping).value(s.v[0]) + whole - e.working[0];
}

/// Springs and dampers of `springs` and of joints.
struct Spring {
  static constexpr LawInfo info{.name = "spring", .list = SpecList::springs, .of_functions = true};

  template <class T>
  static void law(const LawContext<T>& c, ElementState<T>& s) {
    spring_law(c, s);
  }
  static void energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
    spring_energy(c, s, e);
  }
};

/// On a sum of joints' coordinates.
struct TorsionSpring {
  static void check(const spec::Element& e, std::vector<std::string>& faults) {
    if (e.functions.size() != 2 ||
        (e.functions[0].is_zero() && e.functions[1].is_zero() && e.general.formula.is_zero()))
      faults.emplace_back("specifies no force; it has two functions: its elastic law, and its damper's");
  }
  static constexpr LawInfo info{.name = "torsion_spring",
                                .section = "torsion_springs",
                                .coordinates = true,
                                .functions = 2,
                                .of_functions = true,
                                .check = check};

  template <class T>
  static void law(const LawContext<T>& c, ElementState<T>& s) {
    spring_law(c, s);
  }
  static void energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
    spring_energy(c, s, e);
  }
};

}  // namespace mimbre::forces
