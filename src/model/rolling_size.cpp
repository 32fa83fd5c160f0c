#include "model/rolling_size.h"

#include <cmath>

#include "math/elementary.h"
#include "model/force_laws.h"
#include "tyre_files/magic_numbers.h"

namespace mimbre {
namespace {

/// At the nominal load, by the rolling radius of the property file, (A3.6) of Pacejka 2012, and the length of
/// the footprint of its appendix 3's tyre, (A3.7): R (0.671 √(δ/R) + 0.733 δ/R).
RollingSize of_magic_tyre(const std::vector<double>& n) {
  using namespace forces::magic;
  const double radius = n[unloaded_radius], share = n[fnomin] / (n[vertical_stiffness] * radius);
  return {n[dreff] * mimbre::atan(n[breff]) + n[freff], radius * (0.671 * std::sqrt(share) + 0.733 * share)};
}

}  // namespace

RollingSize rolling_size(const spec::Tyre& tyre) {
  if (tyre.law == law_info(static_cast<int>(Law::magic_tyre)).name) return of_magic_tyre(tyre.numbers);
  return {brush_tyre_rolling, tyre.numbers[brush_tyre_half_length]};
}

}  // namespace mimbre
