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
#include "forces/hydraulic_damper.h"
#include "forces/load.h"
#include "forces/magic_tyre.h"
#include "forces/motor.h"
#include "forces/sensor.h"
#include "forces/spring.h"
#include "forces/stop.h"
#include "forces/tmeasy_tyre.h"
#include "forces/tyre.h"
#include "forces/user.h"
#include "spec/force_law.h"

/// The laws of force elements. A new one is a file like gas_spring.h and its name in this list.
namespace mimbre::forces {

template <class... Laws>
struct LawList {};
/// In the order of ElementData::law.
using Laws =
    LawList<Spring, Tyre, Load, Sensor, Actuator, Bushing, User, GasSpring, Friction, Stop, TorsionSpring,
            Cable, Motor, Drag, Contact, BrushTyre, MagicTyre, HydraulicDamper, TmeasyTyre>;

template <class T>
struct LawRow {
  /// Force and tangents of the measure, and the states at the end of the step.
  void (*law)(const LawContext<T>&, ElementState<T>&);
  /// After the law, of numbers only: it is no part of a step.
  void (*energy)(const LawContext<double>&, const ElementState<double>&, ElementEnergy&);
};

template <class T, class... Law>
constexpr std::array<LawRow<T>, sizeof...(Law)> rows_of(LawList<Law...>) {
  return {{{Law::template law<T>, Law::energy}...}};
}
template <class T>
constexpr auto rows = rows_of<T>(Laws());

template <class... Law>
constexpr std::array<const LawInfo*, sizeof...(Law)> infos_of(LawList<Law...>) {
  return {&Law::info...};
}
inline constexpr auto infos = infos_of(Laws());

}  // namespace mimbre::forces
