#include "model/slow_speeds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "joints/table.h"
#include "math/elementary.h"
#include "math/function_values.h"
#include "model/force_laws.h"

namespace mimbre {
namespace {

/// Of the speed √(g L), or √(g/L) for angles: at 1 m and 9.81 m/s² that is 0.01 m/s, or rad/s.
constexpr double slow = 3e-3;
/// Without gravity: a blow that goes only this share of the length scale deep, or so many rad, is slow.
constexpr double shallow = 1e-6;

/// A force element measures m or rad: what is neither small nor large of that, and what resists it, kg or
/// kg m².
struct Scale {
  double size, inertia;
};

Scale scale_of(const Compiled& m, const ElementData& e) {
  const bool turns = e.measure == Measure::coordinate && is_angle(e.joint, e.local);
  return turns ? Scale{1, m.mass_scale * m.length_scale * m.length_scale}
               : Scale{m.length_scale, m.mass_scale};
}

/// √(g/L), 1/s; 0 without gravity.
double pace_of_gravity(const Compiled& m) { return std::sqrt(m.gravity.norm() / m.length_scale); }

/// Stiffness k at the depth e; exponent n: f = k e/n (d/e)ⁿ stops the mechanism's mass at the depth d.
double slow_blow(const Compiled& m, const Scale& scale, double k, double n, double e) {
  if (const double pace = pace_of_gravity(m); pace > 0) return slow * scale.size * pace;
  const double depth = shallow * scale.size;
  return depth * std::sqrt(k * mimbre::pow(depth / e, n - 1) / scale.inertia);
}

/// At the joint. Without gravity: as fast as the motor turns the mechanism while its largest torque moves the
/// joint by 1, or, of a DC motor that this torque is not known of, in the time in which K²/R brakes it.
double slow_gear(const Compiled& m, const ElementData& e) {
  const Scale scale = scale_of(m, e);
  if (const double pace = pace_of_gravity(m); pace > 0) return slow * scale.size * pace;
  const double* p = m.numbers.data() + e.numbers;
  const auto number = [&](std::string_view key) { return p[place_of(motor_numbers, key)]; };
  const double n = std::abs(number("ratio")), constant = number("constant");
  const bool by_curve = e.functions >= 0;
  const double stalled =
      by_curve ? std::abs(value_at(m.functions[e.functions], 0.0)) : constant * number("current_limit");
  double pace =
      std::sqrt(n * std::min(stalled, number("torque_limit")) * scale.size / scale.inertia) / scale.size;
  if (!by_curve) pace = std::min(pace, n * n * constant * constant / number("resistance") / scale.inertia);
  return slow * scale.size * (pace > 0 ? pace : 1);
}

/// That of the numbers with these keys.
template <std::size_t n>
double slow_blow_of(const Compiled& m, const ElementData& e, const std::array<LawNumber, n>& numbers) {
  const double* p = m.numbers.data() + e.numbers;
  const auto number = [&](std::string_view key) { return p[place_of(numbers, key)]; };
  return slow_blow(m, scale_of(m, e), number("stiffness"), number("exponent"), number("depth"));
}

}  // namespace

void find_slow_speeds(Compiled& m) {
  for (const ElementData& e : m.elements) {
    double* const p = m.numbers.data() + e.numbers;
    if (e.law == static_cast<int>(Law::stop)) p[stop_slow] = slow_blow_of(m, e, stop_numbers);
    if (e.law == static_cast<int>(Law::contact)) p[contact_slow] = slow_blow_of(m, e, contact_numbers);
    if (e.law == static_cast<int>(Law::motor))
      p[motor_slow] = std::abs(p[place_of(motor_numbers, "ratio")]) * slow_gear(m, e);
  }
}

}  // namespace mimbre
