#include "compile/slow_speeds.h"

#include <cmath>

#include "joints/joint_kind.h"
#include "math/elementary.h"
#include "spec/force_law.h"

namespace mimbre {
namespace {

/// Without gravity: an impact that goes only this share of the length scale deep, or so many rad, is slow.
constexpr double shallow = 1e-6;

}  // namespace

MeasureScale measure_scale(const Compiled& m, const ElementData& e) {
  const bool turns = e.measure == Measure::coordinate && is_angle(e.joint, e.local);
  return turns ? MeasureScale{1, m.mass_scale * m.length_scale * m.length_scale}
               : MeasureScale{m.length_scale, m.mass_scale};
}

double pace_of_gravity(const Compiled& m) { return std::sqrt(m.gravity.norm() / m.length_scale); }

void set_usual_depth(const Compiled& m, const ElementData& e, double& depth) {
  if (!(depth < by_scales)) depth = usual_depth * measure_scale(m, e).size;
}

/// f stops the mechanism's mass at the depth d.
double slow_impact(const Compiled& m, const ElementData& element, double k, double n, double e) {
  const MeasureScale scale = measure_scale(m, element);
  if (const double pace = pace_of_gravity(m); pace > 0) return slow_share * scale.size * pace;
  const double depth = shallow * scale.size;
  return depth * std::sqrt(k * mimbre::pow(depth / e, n - 1) / scale.inertia);
}

void find_slow_speeds(Compiled& m) {
  for (const ElementData& e : m.elements)
    if (const auto set = law_info(e.law).set_scales) set(m, e, m.numbers.data() + e.numbers);
}

}  // namespace mimbre
