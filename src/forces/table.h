#pragma once
#include <array>

#include "forces/actuator.h"
#include "forces/bushing.h"
#include "forces/gas_spring.h"
#include "forces/load.h"
#include "forces/spring.h"
#include "forces/tyre.h"
#include "forces/user.h"
#include "model/force_laws.h"

/// The laws of force elements. A new one is a file like spring.h, a row here and one in model/force_laws.h.
namespace mimbre::forces {

struct LawRow {
  /// Force and tangents of what is measured, and the states at the end of the step.
  void (*law)(const LawContext<double>&, ElementState<double>&);
  /// After the law.
  void (*energy)(const LawContext<double>&, const ElementState<double>&, ElementEnergy&);
};

inline void no_law(const LawContext<double>&, ElementState<double>& s) {
  for (int k = 0; k < s.count; ++k) s.force[k] = 0;
  for (int k = 0; k < s.count * s.count; ++k) s.stiffness[k] = s.damping[k] = 0;
}
inline void no_energy(const LawContext<double>&, const ElementState<double>&, ElementEnergy&) {}

constexpr std::array<LawRow, law_table.size()> rows{{
    {spring_law, spring_energy},
    {tyre_law, tyre_energy},
    {load_law, load_energy},
    {no_law, no_energy},
    {actuator_law, actuator_energy},
    {bushing_law, bushing_energy},
    {user_law, user_energy},
    {gas_spring_law, gas_spring_energy},
}};

}  // namespace mimbre::forces
