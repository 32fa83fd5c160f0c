#pragma once
#include <algorithm>

#include "forces/element.h"

/// A cable over points: between its ends it runs straight from point to point, over pulleys without friction
/// and without size, so that it has one tension. It pulls with E A times its strain, with a damper of its
/// own, and never pushes: T = k e + d, with k = E A/l₀, the elongation e = l − l₀, and d = c ė within ± k e,
/// so that the tension begins and ends at 0.
namespace mimbre::forces {

namespace cable {
/// Among the law's numbers. `rest_number`: the length without tension, where no signal sets it.
constexpr int stiffness = 0, damping = 1, rest_number = 4;
/// States: the length without tension, the length, and the rate of the former, at the start of the step.
constexpr int rest_before = 0, length_before = 1, reeled_before = 2;
/// A winch does not reel in more than all but this share of the length that the cable begins with.
constexpr double least_rest = 1e-3;

template <class T>
T rest_now(const LawContext<T>& c) {
  const T* p = c.numbers();
  if (!c.has_arguments()) return p[rest_number];
  const T requested = c.argument(0), least = least_rest * p[rest_number];
  return select(requested > least, requested, least);
}

/// The rate of the length without tension: the mean over the step. Where a step begins, that of the signal;
/// the mean over the step before where the signal's is not known.
template <class T>
T reeled_now(const LawContext<T>& c, const T& rest, const T* before) {
  if (!c.has_arguments()) return T(0);
  if (c.step > 0) return (rest - before[rest_before]) / c.step;
  const T least = least_rest * c.numbers()[rest_number];
  return select(c.argument(0) > least, c.argument_rate(0, before[reeled_before]), T(0));
}

inline double stored(double ea, double length, double rest) {
  const double elongation = std::max(0.0, length - rest);
  return 0.5 * ea / rest * elongation * elongation;
}
}  // namespace cable

template <class T>
void cable_law(const LawContext<T>& c, ElementState<T>& s) {
  using namespace cable;
  const T* p = c.numbers();
  const T* before = c.states + c.element.own_states;
  const T rest = rest_now(c), k = p[stiffness] / rest, none(0);
  const T elongation = s.x[0] - rest;
  const T reeled = reeled_now(c, rest, before);
  const T elastic = select(elongation > none, T(k * elongation), none);
  const T damped = p[damping] * (s.v[0] - reeled);
  const auto taut = elastic > none, over = damped > elastic, under = damped < -elastic;
  s.force[0] = elastic + select(over, elastic, select(under, T(-elastic), damped));
  s.stiffness[0] = select(taut, select(over, T(T(2) * k), select(under, none, k)), none);
  s.damping[0] = select(taut, select(over, none, select(under, none, p[damping])), none);
  T* next = s.states + c.element.own_states;
  next[rest_before] = rest;
  next[length_before] = s.x[0];
  next[reeled_before] = reeled;
}

/// A winch puts in what its change of the length stores, and what the damper takes of that. At a step of 0 s
/// the change is a jump, in which no damper works.
inline void cable_energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
  using namespace cable;
  const double ea = c.numbers()[stiffness], rest = rest_now(c), length = s.x[0];
  e.stored = stored(ea, length, rest);
  e.dissipating[0] = s.force[0] - ea / rest * std::max(0.0, length - rest);
  const double* before = c.states + c.element.own_states;
  const double was = before[rest_before], from = before[length_before];
  if (!c.has_arguments() || !(was > 0)) return;
  if (c.step <= 0) {
    e.given = e.stored - stored(ea, length, was);
    return;
  }
  e.given = 0.5 * (e.stored - stored(ea, length, was) + stored(ea, from, rest) - stored(ea, from, was));
  e.wound = rest - was;
}

struct Cable {
  static constexpr std::array<LawNumber, 4> numbers{{
      {.key = "axial_stiffness", .unit = "N", .about = "E A: tension over strain", .above = 0},
      {.key = "damping", .unit = "N s/m", .about = "of the taut cable", .otherwise = 0, .least = 0},
      {.key = "length",
       .unit = "m",
       .about = "without tension; 0: such that the assembled cable has the preload",
       .otherwise = 0,
       .least = 0},
      {.key = "preload", .unit = "N", .about = "tension as assembled", .otherwise = 0, .least = 0},
  }};
  static constexpr std::string_view fault(std::span<const double> n) {
    return n[2] > 0 && n[3] > 0 ? "has a 'length' and a 'preload', which follow from each other; keep one"
                                : "";
  }
  /// The length without tension.
  static void derived(std::span<const double> n, double assembled, std::vector<double>& behind) {
    behind.push_back(n[2] > 0 ? n[2] : assembled / (1 + n[3] / n[0]));
  }
  static constexpr LawInfo info{.name = "cable",
                                .section = "cables",
                                .path = true,
                                .numbers = numbers,
                                .arguments = 1,
                                .optional = true,
                                .states = 3,
                                .fault = fault,
                                .derived = derived};

  template <class T>
  static void law(const LawContext<T>& c, ElementState<T>& s) {
    cable_law(c, s);
  }
  static void energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
    cable_energy(c, s, e);
  }
};

}  // namespace mimbre::forces
