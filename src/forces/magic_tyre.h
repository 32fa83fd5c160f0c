#pragma once
#include <algorithm>
#include <cmath>
#include <utility>

#include "forces/brush_tyre.h"
#include "forces/carcass.h"
#include "forces/element.h"
#include "forces/magic_formula.h"
#include "forces/measure_wheel.h"
#include "math/elementary.h"
#include "math/smooth.h"

/// A tyre by the Magic Formula, which knows forces of steady slip. The slip is that of a brush behind a
/// carcass (forces/carcass.h) with the slip stiffnesses, the relaxation lengths and the friction of the
/// formula: where it rolls steadily that is the wheel's own; a wheel that stands has the brush's forces.
/// Speeds, lengths and forces below are by those of the tyre: the speed LONGVL of its measurement, its radius
/// and its nominal load.
namespace mimbre::forces {

namespace magic_tyre {
/// Among the law's numbers, behind the vertical stiffness and the radius: those of the formula, then the
/// carcass's damping over its stiffness.
constexpr int formula = 2, settling = formula + magic::count;
/// Among the states: the bend of the carcass; what that stores, J.
constexpr int bend = wheel::bend, stored = bend + 2;

/// From this speed on, 0.5 m/s at the usual 16.7 m/s, forces are the formula's alone.
constexpr double rolls = 0.03;
/// No relaxation length is taken to be shorter, no slip stiffness to be less.
constexpr double shortest = 0.03, softest = 2.5e-4;

template <class T>
T pressure(const T* n) {
  return (n[magic::inflpres] - n[magic::nompres]) / n[magic::nompres];
}
template <class T>
MagicVertical<T> vertical(const T* n, const ElementState<T>& s) {
  MagicVerticalInput<T> in;
  in.deflection = T(-1) * s.x[wheel::gap];
  in.rate = T(-1) * s.v[wheel::gap];
  in.omega = s.surroundings[wheel::spin];
  in.gamma = s.surroundings[wheel::camber];
  in.dpi = pressure(n);
  return magic_vertical(n, in);
}
/// The formula at small slip: the carcass's stiffness, slip stiffness and limit.
template <class T>
void small_slip(const T* n, const MagicInput<T>& in, carcass::Wheel<T>& w) {
  using namespace magic;
  const Terms<T> t = terms(n, in);
  const PureLateral<T> y = pure_lateral(t, t.sin_gamma);
  MagicOutput<T> out;
  out.Kx = slip_stiffness(t);
  out.Ky = y.stiffness;
  relaxation(t, out);
  const T stiffness[2] = {size_of(out.Kx), size_of(out.Ky)};
  const T lengths[2] = {out.sigma_kappa, out.sigma_alpha};
  for (int k = 0; k < 2; ++k) {
    w.stiffness[k] = t.beyond * greatest(stiffness[k], T(T(softest) * n[fnomin]));
    w.spring[k] = w.stiffness[k] / greatest(lengths[k], T(T(shortest) * n[unloaded_radius]));
  }
  const T along = (n[pdx1] + n[pdx2] * t.dfz) * t.mu_x;
  w.limit = t.beyond * t.load * greatest(T(T(0.5) * (along + y.friction)), T(0));
}
/// The formula's share of the forces, by the mean square of both speeds: 1 from `rolls` on.
template <class T>
T share_of_formula(const T* n, const T& forward, const T& rolling) {
  const T full = T(rolls) * n[magic::longvl],
          r = T(0.5) * (forward * forward + rolling * rolling) / (full * full);
  return select(r < T(1), T(r * (T(2) - r)), T(1));
}
}  // namespace magic_tyre

template <class T>
void magic_tyre_law(const LawContext<T>& c, ElementState<T>& s) {
  using namespace magic_tyre;
  using std::abs, mimbre::atan2;
  const T* n = c.numbers() + formula;
  for (int k = 0; k < s.count; ++k) s.force[k] = T(0);
  for (int k = 0; k < s.count * s.count; ++k) s.stiffness[k] = s.damping[k] = T(0);
  const MagicVertical<T> push = vertical(n, s);
  s.force[wheel::gap] = T(-1) * push.force;
  s.stiffness[0] = push.stiffness;
  s.damping[0] = push.damping;

  const T slow = T(magic::slow) * n[magic::longvl];
  wheel::set_stood(c.element, slow, s);
  const T rolling = wheel::rolling_speed(c.element, s), forward = s.surroundings[wheel::forward];
  MagicInput<T> in;
  in.Fz = push.force;
  in.kappa = in.alpha = T(0);
  in.gamma = s.surroundings[wheel::camber];
  in.dpi = pressure(n);
  in.Vx = forward;
  in.lmu = s.surroundings[wheel::friction];
  carcass::Wheel<T> w;
  small_slip(n, in, w);
  w.settling = c.numbers()[settling];
  w.rolled = abs(rolling);
  w.bend = c.states + bend;
  w.rate = s.v + wheel::forth;
  if (c.step <= 0) w.gone = wheel::gone(c.element, c.states, s);
  const carcass::Followed<T> footprint = carcass::follow(w, c.step);
  carcass::put_tangents(footprint, wheel::forth, s);

  const T speed = smooth::size(forward, slow);
  in.kappa = T(-1) * footprint.slip[0] / speed;
  in.alpha = atan2(footprint.slip[1], speed);
  const MagicOutput<T> out = magic_formula(n, in);
  const T moves = share_of_formula(n, forward, rolling);
  s.force[wheel::forth] = (T(1) - moves) * footprint.shear.force[0] - moves * out.Fx;
  s.force[wheel::across] = (T(1) - moves) * footprint.shear.force[1] - moves * out.Fy;
  s.force[wheel::overturning] = T(-1) * moves * out.Mx;
  s.force[wheel::rolling] = T(-1) * moves * out.My;
  s.force[wheel::aligning] = T(-1) * moves * out.Mz;
  s.states[stored] = T(0);
  for (int k = 0; k < 2; ++k) {
    s.states[bend + k] = footprint.bend[k];
    s.states[stored] += T(0.5) * w.spring[k] * footprint.bend[k] * footprint.bend[k];
  }
}

/// The spring of a tyre that neither turns faster nor slower stores, and the carcass; all that forces along
/// the road do beyond is lost.
inline void magic_tyre_energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
  using namespace magic_tyre;
  const double* n = c.numbers() + formula;
  // The force is a polynomial of the deflection, but for the rim and the hub: the integral of it by Gauss's
  // rule is exact from one to the next.
  const double R = n[magic::unloaded_radius], deep = -s.x[wheel::gap], hub = std::min(R, deep),
               free = std::min(R - magic_free_radius(n, s.surroundings[wheel::spin]), hub),
               rim = std::clamp(R - n[magic::rim_radius] - n[magic::bottom_offst], free, hub);
  ElementState<double> at = s;
  double still = 0, place = 0;
  at.x = &place;
  at.v = &still;
  const auto spring = [&](double deflection) {
    place = -deflection;
    return vertical(n, at).force;
  };
  for (const auto& [from, to] : {std::pair(free, rim), std::pair(rim, hub), std::pair(hub, deep)}) {
    const double half = 0.5 * (to - from), middle = 0.5 * (from + to), off = half / std::sqrt(3.0);
    e.stored += half * (spring(middle - off) + spring(middle + off));
  }
  e.dissipating[wheel::gap] = s.force[wheel::gap] + spring(deep);
  for (int k = wheel::forth; k < s.count; ++k) e.dissipating[k] = s.force[k];
  e.stored += s.states[stored];
  if (c.step > 0) e.lost = c.states[stored] - s.states[stored];
}

/// Behind the vertical stiffness and the radius stand the numbers of the formula, then the settling time.
struct MagicTyre {
  static constexpr std::array<LawNumber, 1> numbers{BrushTyre::numbers.back()};
  /// Numbers of the formula, as a property file gives them (mimbre/tyre_file.h), and the carcass's damping.
  static void check_file(std::span<const double> n, std::vector<std::string>& faults) {
    using namespace magic;
    if (n.size() != count + 1) {
      faults.push_back(fmt::format("law 'magic_tyre' has {} numbers, {} are given", count + 1, n.size()));
      return;
    }
    for (std::size_t k = 0; k + 1 < n.size(); ++k)
      if (!std::isfinite(n[k])) faults.push_back(fmt::format("number {} is not finite", k));
    for (const Number k : {unloaded_radius, fnomin, longvl, nompres, vertical_stiffness, lfzo})
      if (!(n[static_cast<std::size_t>(k)] > 0))
        faults.push_back(fmt::format("{} is {}; it has to be above 0", magic::rows[k].key,
                                     n[static_cast<std::size_t>(k)]));
    if (!(n.back() >= 0)) faults.push_back(fmt::format("settling is {}; it cannot be below 0", n.back()));
  }
  static void set_scales(const Compiled& m, const ElementData& e, double* p) {
    set_settling(m, e, p[magic_tyre::formula + magic::vertical_stiffness], p[magic_tyre::settling]);
  }
  static double slow_speed(const double* p) { return magic::slow * p[magic_tyre::formula + magic::longvl]; }
  /// At the nominal load, by the rolling radius of the property file, (A3.6) of Pacejka 2012, and the length
  /// of the footprint of its appendix 3's tyre, (A3.7): R (0.671 √(δ/R) + 0.733 δ/R).
  static RollingSize rolling_size(std::span<const double> n) {
    using namespace magic;
    const double radius = n[unloaded_radius], share = n[fnomin] / (n[vertical_stiffness] * radius);
    return {n[dreff] * mimbre::atan(n[breff]) + n[freff],
            radius * (0.671 * std::sqrt(share) + 0.733 * share)};
  }
  static constexpr LawInfo info{.name = "magic_tyre",
                                .list = SpecList::tyres,
                                .numbers = numbers,
                                .states = 10,
                                .set_scales = set_scales,
                                .model = "magic_formula",
                                .by_file = true,
                                .check_file = check_file,
                                .slow_speed = slow_speed,
                                .rolling_size = rolling_size};

  template <class T>
  static void law(const LawContext<T>& c, ElementState<T>& s) {
    magic_tyre_law(c, s);
  }
  static void energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
    magic_tyre_energy(c, s, e);
  }
};

}  // namespace mimbre::forces
