#pragma once
#include <array>

#include "constraints/constant_velocity.h"
#include "constraints/coupling.h"
#include "constraints/distance.h"
#include "constraints/knife_edge.h"
#include "constraints/on_curve.h"
#include "constraints/on_line.h"
#include "constraints/on_plane.h"
#include "constraints/orientation.h"
#include "constraints/parallel.h"
#include "constraints/perpendicular.h"
#include "constraints/rolling.h"
#include "constraints/rolling_on_road.h"
#include "constraints/screw.h"

/// The kinds of constraints. A new one is a file like screw.h and its name in this list.
namespace mimbre::constraints {

template <class... Kinds>
struct KindList {};
/// In the order of ConstraintData::kind.
using Kinds = KindList<Coupling, Distance, OnLine, OnPlane, OnCurve, Parallel, Perpendicular,
                       ConstantVelocity, Screw, Orientation, Rolling, RollingOnRoad, KnifeEdge>;

/// The equations of one term of a constraint: `equations` of its kind; of a coupling the term's share.
template <class T>
using EquationsOf = void (*)(const EquationContext<T>&, ScalarEquation<T>*);
template <class T, class... Kind>
constexpr std::array<EquationsOf<T>, sizeof...(Kind)> equations_of(KindList<Kind...>) {
  return {Kind::template equations<T>...};
}
template <class T>
constexpr auto equations = equations_of<T>(Kinds());

template <class... Kind>
constexpr std::array<const ConstraintInfo*, sizeof...(Kind)> infos_of(KindList<Kind...>) {
  return {&Kind::info...};
}
inline constexpr auto infos = infos_of(Kinds());

/// Most equations that one has.
constexpr int most_equations = 6;
static_assert([] {
  for (const ConstraintInfo* info : infos)
    if (info->equations > most_equations) return false;
  return true;
}());

}  // namespace mimbre::constraints
