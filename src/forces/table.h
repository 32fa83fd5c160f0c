#pragma once
#include <array>

#include "forces/actuator.h"
#include "forces/brush_tyre.h"
#include "forces/bushing.h"
#include "forces/cable.h"
#include "forces/contact.h"
#include "forces/drag.h"
#include "forces/friction.h"
#include "forces/gas_spring.h"
#include "forces/load.h"
#include "forces/magic_tyre.h"
#include "forces/motor.h"
#include "forces/spring.h"
#include "forces/stop.h"
#include "forces/tyre.h"
#include "forces/user.h"
#include "model/force_laws.h"

/// The laws of force elements. A new one is a file like spring.h, a row here and one in model/force_laws.h.
namespace mimbre::forces {

template <class T>
struct LawRow {
  /// Force and tangents of what is measured, and the states at the end of the step.
  void (*law)(const LawContext<T>&, ElementState<T>&);
  /// After the law, of numbers only: it is no part of a step.
  void (*energy)(const LawContext<double>&, const ElementState<double>&, ElementEnergy&);
};

template <class T>
void no_law(const LawContext<T>&, ElementState<T>& s) {
  for (int k = 0; k < s.count; ++k) s.force[k] = T(0);
  for (int k = 0; k < s.count * s.count; ++k) s.stiffness[k] = s.damping[k] = T(0);
}
inline void no_energy(const LawContext<double>&, const ElementState<double>&, ElementEnergy&) {}

template <class T>
constexpr std::array<LawRow<T>, law_table.size()> rows{{
    {spring_law, spring_energy},
    {tyre_law, tyre_energy},
    {load_law, load_energy},
    {no_law, no_energy},
    {actuator_law, actuator_energy},
    {bushing_law, bushing_energy},
    {user_law, user_energy},
    {gas_spring_law, gas_spring_energy},
    {friction_law, friction_energy},
    {stop_law, stop_energy},
    {spring_law, spring_energy},
    {cable_law, cable_energy},
    {motor_law, motor_energy},
    {drag_law, drag_energy},
    {contact_law, contact_energy},
    {brush_tyre_law, brush_tyre_energy},
    {magic_tyre_law, magic_tyre_energy},
}};

}  // namespace mimbre::forces
