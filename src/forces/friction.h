#pragma once
#include <algorithm>
#include <cmath>

#include "compile/slow_speeds.h"
#include "forces/element.h"
#include "math/elementary.h"

/// Dry friction on a joint's coordinate, with sticking. Bristles, springs with dampers, hold the surfaces
/// together until their force reaches the limit; then the surfaces slide and the bristles stay bent. That is
/// the return to the limit of a perfectly plastic spring in row (Simo and Hughes, Computational Inelasticity,
/// 1998, 1.4), so that under a load below the limit, however it varies, nothing creeps. The limit goes with
/// the speed as Stribeck's: μ(v) = 1 + (static_ratio − 1) exp(−(v/stribeck)²), times what is given.
namespace mimbre::forces {

namespace friction {
/// Among the law's numbers. `sticking`: how far the bristles bend before they slide, at static_ratio 1.
constexpr int sticking = 0, static_ratio = 1, stribeck = 2, viscous = 3, settling = 4;
/// Behind those given, of defaults without gravity: `stribeck` over the root of the limit in fast sliding,
/// and `settling` times that root.
constexpr int stribeck_by_root = 5, settling_by_root = 6;
/// States, behind the turns: bend of the bristles, its rate, the measure at the start of the step, and
/// whether that is known.
constexpr int bend = 0, rate = 1, place = 2, known = 3;

/// What starts slower than this share of `stribeck` is at rest.
constexpr double still = 1e-7;

/// Square of the share of their whole bend up to which bristles stick.
constexpr double nearly = 1 - 1e-6;

/// The default of `sticking`, by the length scale, or in rad.
constexpr double usual_sticking = 1e-5;

template <class T>
struct Bristles {
  T bend, rate, force;
  T stiffness, damping;  ///< ∂force/∂x, ∂force/∂v
};

template <class T>
Bristles<T> bristles(const LawContext<T>& c, const T& x, const T& v) {
  using mimbre::exp;
  using std::sqrt;
  const T* p = c.numbers();
  const T* before = c.states + c.element.own_states;
  const T given = c.argument(0), level = select(given > T(0), given, T(0));
  // Surfaces that nothing presses together bend nothing: a brake that opens lets go.
  const auto pressed = level > T(0);
  const T root = sqrt(select(pressed, level, T(1)));
  const T slow = p[stribeck] + p[stribeck_by_root] * root, settles = p[settling] + p[settling_by_root] / root;
  const T rest = T(still) * slow;
  const T moves = select(v > rest, T(1), select(v < -rest, T(-1), T(0)));
  const T speed = v / slow, peak = (p[static_ratio] - T(1)) * exp(-speed * speed);
  const T limit = level * (T(1) + peak), slope = level * peak * (T(-2) * speed / slow);
  const T k = level / p[sticking], viscosity = k * settles;
  // What slides as it starts has bent them.
  const auto begun = before[known] > T(0.5);
  const T full = p[sticking] * (T(1) + peak), slides = T(moves * full);
  const T moved = select(begun, T(x - before[place]), T(0)), bent = select(begun, before[bend], slides);
  Bristles<T> b;
  // Their damper's part over the step; where there is none, the rate stays.
  const bool steps = c.step > 0;
  const T damped = steps ? T(viscosity / c.step) : T(0), kept = steps ? T(0) : T(viscosity * before[rate]);
  const T whole = k + damped;
  const T trial = k * bent + whole * moved + kept;
  // At the limit, and going on: it slides, with the tangents of that.
  const T reach = select(T(trial * v) > T(0), T(1 - 1e-12), T(1));
  // The first iterate of a step may lie far beyond the little way on which it sticks.
  const auto stuck =
      c.holds > T(0.5) && begun && (trial * bent < T(0) || bent * bent < T(nearly) * full * full);
  const T most = select(stuck, T(trial * trial), T(reach * limit * limit));
  const auto sliding = trial * trial > most;
  const T side = select(trial > T(0), T(1), T(-1));
  // Sliding: k z + damped (z − z before) + kept = ± limit.
  const T held = select(whole > T(0), T((side * limit - kept + damped * bent) / (whole + T(1e-300))), T(0));
  b.bend = select(pressed, select(sliding, held, T(bent + moved)), T(0));
  b.rate = steps ? select(pressed, T((b.bend - bent) / c.step), T(0)) : before[rate];
  b.force = select(sliding, T(side * limit), trial);
  b.stiffness = select(sliding, T(0), whole);
  b.damping = select(sliding, T(side * slope), T(0));
  return b;
}
}  // namespace friction

template <class T>
void friction_law(const LawContext<T>& c, ElementState<T>& s) {
  using namespace friction;
  const Bristles<T> b = bristles(c, s.x[0], s.v[0]);
  const T viscosity = c.numbers()[viscous];
  s.force[0] = b.force + viscosity * s.v[0];
  s.stiffness[0] = b.stiffness;
  s.damping[0] = b.damping + viscosity;
  T* next = s.states + c.element.own_states;
  next[bend] = b.bend;
  next[rate] = b.rate;
  next[place] = s.x[0];
  next[known] = T(1);
}

/// The bristles store what bends them; what the surfaces slide, and what the bristles' damper takes, is lost.
inline void friction_energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
  using namespace friction;
  const double* p = c.numbers();
  const Bristles<double> b = bristles(c, s.x[0], s.v[0]);
  const double k = std::max(0.0, c.argument(0)) / p[sticking];
  e.stored = e.held = 0.5 * k * b.bend * b.bend;
  e.inner[0] = b.force;
  e.dissipating[0] = p[viscous] * s.v[0];
}

struct Friction {
  static constexpr std::array<LawNumber, 5> numbers{{
      {.key = "sticking",
       .unit = "m|rad",
       .about = "elastic presliding displacement",
       .otherwise = by_scales,
       .above = 0},
      {.key = "static_ratio",
       .about = "of the limit at rest to that in fast sliding",
       .otherwise = 1,
       .least = 1},
      {.key = "stribeck",
       .unit = "m/s|rad/s",
       .about = "speed over which the limit falls to that in fast sliding",
       .otherwise = by_scales,
       .above = 0},
      {.key = "viscous", .unit = "N s/m|N m s/rad", .about = "damping beside", .otherwise = 0, .least = 0},
      {.key = "settling",
       .unit = "s",
       .about = "time constant of the decay of vibrations while sticking",
       .otherwise = by_scales,
       .least = 0},
  }};
  /// friction::stribeck_by_root, friction::settling_by_root.
  static void derived(std::span<const double>, double, std::vector<double>& behind) {
    behind.insert(behind.end(), {0, 0});
  }
  /// Speeds and times are shares of those of a pendulum of the length scale. Without gravity the
  /// acceleration that the friction's own limit causes takes its place.
  static void set_scales(const Compiled& m, const ElementData& e, double* p) {
    using namespace friction;
    const MeasureScale scale = measure_scale(m, e);
    const double pace = pace_of_gravity(m);
    const auto find = [&](int number, int by_root, double by_gravity, double by_limit) {
      if (p[number] < by_scales) return;
      p[number] = pace > 0 ? slow_share * by_gravity : 0;
      p[by_root] = pace > 0 ? 0 : slow_share * by_limit;
    };
    if (!(p[sticking] < by_scales)) p[sticking] = usual_sticking * scale.size;
    find(stribeck, stribeck_by_root, scale.size * pace, std::sqrt(scale.size / scale.inertia));
    find(settling, settling_by_root, 1 / pace, std::sqrt(scale.size * scale.inertia));
  }
  static constexpr LawInfo info{.name = "friction",
                                .section = "frictions",
                                .coordinate = true,
                                .numbers = numbers,
                                .arguments = 1,
                                .states = 4,
                                .sticks = true,
                                .derived = derived,
                                .set_scales = set_scales,
                                .drawn_at_joint = "friction"};

  template <class T>
  static void law(const LawContext<T>& c, ElementState<T>& s) {
    friction_law(c, s);
  }
  static void energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
    friction_energy(c, s, e);
  }
};

}  // namespace mimbre::forces
