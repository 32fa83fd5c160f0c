#pragma once
#include "compile/compiled.h"
#include "spec/number_key.h"

/// Speeds below which laws of force elements count motion as rest: impacts of stops and contacts
/// (forces/impact.h), the turning of a motor's gear (forces/motor.h), a tyre that hardly rolls; and defaults
/// of numbers that have units. They are shares of what the mechanism itself has, by its length scale and
/// gravity, so that no unit of length or time counts.
namespace mimbre {

/// The default of a number that LawInfo::set_scales() finds.
constexpr double by_scales = LawNumber::none;

/// Of the speed √(g L), or √(g/L) for angles: at 1 m and 9.81 m/s² that is 0.01 m/s, or rad/s.
constexpr double slow_share = 3e-3;

/// A force element measures m or rad: what is neither small nor large of that, and what resists it, kg or
/// kg m².
struct MeasureScale {
  double size, inertia;
};
MeasureScale measure_scale(const Compiled& model, const ElementData& element);

/// √(g/L), 1/s; 0 without gravity.
double pace_of_gravity(const Compiled& model);

/// The depth at which stops and contacts have their stiffness, by the length scale, or in rad.
constexpr double usual_depth = 1e-3;
/// Sets a depth that is by_scales.
void set_usual_depth(const Compiled& model, const ElementData& element, double& depth);

/// The speed of a slow impact on a stiffness k at the depth e, exponent n: f = k e/n (d/e)ⁿ.
double slow_impact(const Compiled& model, const ElementData& element, double k, double n, double e);

/// Calls LawInfo::set_scales() of every element; after find_scales().
void find_slow_speeds(Compiled& model);

}  // namespace mimbre
