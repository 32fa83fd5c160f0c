#pragma once
#include <cmath>

#include "forces/element.h"

/// A hydraulic damper with compressible oil: a piston with a rod on both sides drives oil through orifices
/// from one chamber to the other. The oil's compression is a spring in series with the orifices:
///   Ḟ = K (ẋ − w),  F = c w + d w |w|,  K = 2 B A/l,
/// with the part w of the piston's speed that the orifices pass, the laminar and turbulent resistance c and
/// d, the bulk modulus B, the piston's area A and the length l of each column of oil. (Merritt, Hydraulic
/// Control Systems, 1967, sections 3.2 and 6.2: continuity of a double-ended cylinder, flow through
/// orifices.)
namespace mimbre::forces {

namespace hydraulic_damper {
/// Among the law's numbers. Behind those given: K.
constexpr int damping = 0, quadratic = 1, area = 2, length = 3, bulk_modulus = 4, stiffness = 5;
/// States: the force, and the measure, at the start of the step.
constexpr int force = 0, place = 1;
/// Of the rule: the two-stage diagonally implicit one of order 2 that damps what is stiff (Alexander, SIAM J.
/// Numer. Anal. 14, 1977).
inline constexpr double gamma = 1 - 0.70710678118654752440;

/// w at the force F + g w = f, where g ≥ 0, and its derivative by f.
template <class T>
struct Flow {
  T speed, slope;
};
template <class T>
Flow<T> flow(const T* p, const T& f, const T& g) {
  using std::sqrt;
  const T linear = p[damping] + g, size = select(f < T(0), T(-f), f);
  const T root = sqrt(T(linear * linear + T(4) * p[quadratic] * size));
  return {T(T(2) * f / (linear + root)), T(T(1) / root)};
}

template <class T>
struct Step {
  T force, tangent;  ///< at its end, and by the measure there
};
/// The measure changes by `moved` at an even rate over h > 0.
template <class T>
Step<T> step(const T* p, const T& before, const T& moved, double h) {
  const T K = p[stiffness], inside = T(gamma * h) * K, rest = T((1 - gamma) * h) * K;
  // Stage k: F + γ h K w(F) = f.
  const T first = before + T(gamma) * K * moved;
  const Flow<T> a = flow(p, first, inside);
  const T second = before + K * moved - rest * a.speed;
  const Flow<T> b = flow(p, second, inside);
  const T slope = K - rest * a.slope * T(gamma) * K;
  return {T(second - inside * b.speed), T(slope * (T(1) - inside * b.slope))};
}
}  // namespace hydraulic_damper

struct HydraulicDamper {
  static constexpr std::array<LawNumber, 5> numbers{{
      {.key = "damping", .unit = "N s/m", .about = "force over speed when slow", .above = 0},
      {.key = "quadratic",
       .unit = "N s^2/m^2",
       .about = "force over squared speed of the orifices",
       .otherwise = 0,
       .least = 0},
      {.key = "area", .unit = "m^2", .about = "of the piston", .above = 0},
      {.key = "length", .unit = "m", .about = "of the oil column in each chamber", .above = 0},
      {.key = "bulk_modulus", .unit = "Pa", .about = "of the oil", .otherwise = 1.4e9, .above = 0},
  }};
  /// K.
  static void derived(std::span<const double> n, double, std::vector<double>& behind) {
    using namespace hydraulic_damper;
    behind.push_back(2 * n[bulk_modulus] * n[area] / n[length]);
  }
  static constexpr LawInfo info{.name = "hydraulic_damper",
                                .section = "hydraulic_dampers",
                                .along = true,
                                .numbers = numbers,
                                .states = 2,
                                .derived = derived,
                                .drawn_along = "damper"};

  /// A step of 0 s is a position at rest, in which the oil stays compressed as it is.
  template <class T>
  static void law(const LawContext<T>& c, ElementState<T>& s) {
    using namespace hydraulic_damper;
    const T *p = c.numbers(), *before = c.states + c.element.own_states;
    Step<T> end{before[force], T(0)};
    if (c.step > 0) end = step(p, before[force], T(s.x[0] - before[place]), c.step);
    s.force[0] = end.force;
    s.stiffness[0] = end.tangent;
    s.damping[0] = T(0);
    T* next = s.states + c.element.own_states;
    next[force] = end.force;
    next[place] = s.x[0];
  }

  /// The oil stores F²/2K; the orifices take F w.
  static void energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
    using namespace hydraulic_damper;
    const double* p = c.numbers();
    const auto lost = [&](double f) { return f * flow(p, f, 0.0).speed; };
    e.stored = 0.5 * s.force[0] * s.force[0] / p[stiffness];
    if (c.step > 0) e.lost = 0.5 * c.step * (lost(c.states[c.element.own_states + force]) + lost(s.force[0]));
  }
};

}  // namespace mimbre::forces
