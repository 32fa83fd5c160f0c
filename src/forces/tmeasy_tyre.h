#pragma once
#include <cmath>

#include "forces/brush_tyre.h"
#include "forces/carcass.h"
#include "forces/element.h"
#include "forces/measure_wheel.h"
#include "math/smooth.h"

/// TMeasy: forces of steady slip by a curve of five numbers for each direction, which can be read from a
/// diagram or estimated: the slope at no slip, the peak and its slip, the force of sliding and the slip from
/// which all slides (Rill, Road Vehicle Dynamics, 2012, 3.3 to 3.8). As a tyre by the Magic Formula it gets
/// its slip from a brush behind a carcass (forces/carcass.h), so that it holds at standstill.
namespace mimbre::forces {

namespace tmeasy {
/// Among the law's numbers, behind the vertical stiffness and the radius. For each direction, along and
/// across, stand five at the load and the ratios of those at twice the load to these.
constexpr int damping = 2, at_load = 3, growth = at_load + 10, relaxation = growth + 10, half_length = 25,
              load = 26, trail = 27, trail_zero = 28, trail_end = 29, resistance = 30, settling = 31,
              slow = 32;
/// Of the five.
constexpr int slope = 0, peak = 1, peak_slip = 2, sliding = 3, sliding_slip = 4;
/// Among the states: the bend of the carcass; what that stores, J.
constexpr int bend = wheel::bend, stored = bend + 2;

template <class T>
struct Curve {
  T slope, peak, peak_slip, sliding, sliding_slip;  ///< N, N, 1, N, 1
};

/// Force at a slip s ≥ 0, N.
///
///   s ≤ s_M:  F = s_M F' σ / (1 + σ (σ + F' s_M/F_M − 2)),  σ = s/s_M
///   s ≤ s_S:  F = F_M − (F_M − F_S) σ² (3 − 2σ),            σ = (s − s_M)/(s_S − s_M)
///   beyond:   F = F_S
template <class T>
T force_at(const Curve<T>& c, const T& s) {
  const T rising = s / c.peak_slip;
  const T below =
      c.peak_slip * c.slope * rising / (T(1) + rising * (rising + c.slope * c.peak_slip / c.peak - T(2)));
  const T falling = (s - c.peak_slip) / (c.sliding_slip - c.peak_slip);
  const T between = c.peak - (c.peak - c.sliding) * falling * falling * (T(3) - T(2) * falling);
  return select(rising < T(1), below, select(falling < T(1), between, c.sliding));
}

/// At `ratio` of the load: forces and slopes as parabolas, slips as lines, through what is given at the load
/// and at twice the load; beyond twice the load forces go with the load. `grip`: factor on friction.
template <class T>
Curve<T> curve_at(const T* p, int direction, const T& ratio, const T& grip) {
  const T* const at = p + at_load + 5 * direction;
  const T* const by = p + growth + 5 * direction;
  const auto within = ratio < T(2);
  const T r = select(within, ratio, T(2)), beyond = select(within, T(1), T(T(0.5) * ratio));
  const auto force = [&](int k) {
    return T(beyond * at[k] * r * (T(2) - T(0.5) * by[k] - (T(1) - T(0.5) * by[k]) * r));
  };
  const auto slip = [&](int k) { return T(at[k] * (T(1) + (by[k] - T(1)) * (r - T(1)))); };
  return {force(slope), grip * force(peak), grip * slip(peak_slip), grip * force(sliding),
          grip * slip(sliding_slip)};
}

/// The curve in a direction between both: by slips over `size`, of which `along` and `across` are the cosine
/// and the sine.
template <class T>
Curve<T> combined(const Curve<T>& x, const Curve<T>& y, const T* size, const T& along, const T& across) {
  using std::sqrt;
  const auto both = [&](const T& a, const T& b) {
    return T(sqrt(T(a * along * a * along + b * across * b * across)));
  };
  return {both(T(x.slope * size[0]), T(y.slope * size[1])), both(x.peak, y.peak),
          both(T(x.peak_slip / size[0]), T(y.peak_slip / size[1])), both(x.sliding, y.sliding),
          both(T(x.sliding_slip / size[0]), T(y.sliding_slip / size[1]))};
}

/// Forces of a slip along and across, in its direction, N.
template <class T>
std::array<T, 2> steady_force(const Curve<T>& x, const Curve<T>& y, const T* slip) {
  using std::sqrt;
  const T flat_x = x.peak / x.slope, flat_y = y.peak / y.slope;
  const T size[2] = {x.peak_slip / (x.peak_slip + y.peak_slip) + flat_x / (flat_x + flat_y),
                     y.peak_slip / (x.peak_slip + y.peak_slip) + flat_y / (flat_x + flat_y)};
  const T a = slip[0] / size[0], b = slip[1] / size[1];
  const T all = sqrt(T(a * a + b * b + T(1e-30)));
  const T along = a / all, across = b / all;
  const T force = force_at(combined(x, y, size, along, across), all);
  return {T(force * along), T(force * across)};
}

/// Lever of the force across over the length of the footprint, by the one of no slip.
template <class T>
T trail_at(const T* p, const T& slip) {
  using std::abs;
  const T s0 = p[trail_zero], end = p[trail_end], w = s0 / end, s = abs(slip) / s0;
  const T below = (T(1) - w) * (T(1) - s) + w * (T(1) - (T(3) - T(2) * s) * s * s);
  const T left = (end - abs(slip)) / (end - s0);
  const T between = (w - T(1)) * (s - T(1)) * left * left;
  return select(s < T(1), below, select(left > T(0), between, T(0)));
}

/// The share of these forces, by the mean square of the speeds forwards and of rolling, as of the Magic
/// Formula: 1 from this many times the speed at which it hardly rolls.
constexpr double rolls = 2.5;
template <class T>
T share_of_curves(const T& slow_speed, const T& forward, const T& rolling) {
  const T full = T(rolls) * slow_speed, r = T(0.5) * (forward * forward + rolling * rolling) / (full * full);
  return select(r < T(1), T(r * (T(2) - r)), T(1));
}
}  // namespace tmeasy

template <class T>
void tmeasy_law(const LawContext<T>& c, ElementState<T>& s) {
  using namespace tmeasy;
  using std::abs, std::sqrt;
  const int n = s.count;
  const T* p = c.numbers();
  for (int k = 0; k < n; ++k) s.force[k] = T(0);
  for (int k = 0; k < n * n; ++k) s.stiffness[k] = s.damping[k] = T(0);
  const brush_tyre::Vertical<T> push =
      brush_tyre::vertical<T>(p[brush_tyre::stiffness], p[damping], s.x[wheel::gap], s.v[wheel::gap]);
  s.force[wheel::gap] = T(-1) * push.force;
  s.stiffness[0] = push.stiffness;
  s.damping[0] = push.damping;

  // A wheel without load has the curves of a small one, which its load then takes away.
  const T full = push.force / p[load];
  const T ratio = select(full > T(1e-6), full, T(1e-6));
  const T grip = s.surroundings[wheel::friction], gripped = select(grip > T(1e-6), grip, T(1e-6));
  const Curve<T> curves[2] = {curve_at(p, 0, ratio, gripped), curve_at(p, 1, ratio, gripped)};
  const T rolling = wheel::rolling_speed(c.element, s);
  wheel::set_stood(c.element, p[slow], s);
  carcass::Wheel<T> w;
  for (int k = 0; k < 2; ++k) {
    w.stiffness[k] = curves[k].slope;
    w.spring[k] = p[at_load + 5 * k + slope] / p[relaxation + k];
  }
  w.settling = p[settling];
  w.rolled = abs(rolling);
  w.limit = select(push.force > T(0), T(T(0.5) * (curves[0].peak + curves[1].peak)), T(0));
  w.bend = c.states + bend;
  w.rate = s.v + wheel::forth;
  if (c.step <= 0) w.gone = wheel::gone(c.element, c.states, s);
  const carcass::Followed<T> footprint = carcass::follow(w, c.step);
  carcass::put_tangents(footprint, wheel::forth, s);

  const T speed = smooth::size(rolling, p[slow]);
  const T slip[2] = {footprint.slip[0] / speed, footprint.slip[1] / speed};
  const std::array<T, 2> steady = steady_force(curves[0], curves[1], slip);
  const T moves = share_of_curves(p[slow], s.surroundings[wheel::forward], rolling);
  const T on = select(push.force > T(0), T(1), T(0));
  s.states[stored] = T(0);
  for (int k = 0; k < 2; ++k) {
    s.force[wheel::forth + k] = (T(1) - moves) * footprint.shear.force[k] + moves * on * steady[k];
    s.states[bend + k] = footprint.bend[k];
    s.states[stored] += T(0.5) * w.spring[k] * footprint.bend[k] * footprint.bend[k];
  }

  const T forwards = smooth::direction(rolling, p[slow]);
  const T lever = push.force * p[resistance] * p[brush_tyre::radius];
  s.force[wheel::rolling] = lever * forwards;
  s.damping[wheel::rolling * (n + 1)] =
      lever * p[brush_tyre::radius] * smooth::direction_slope(rolling, p[slow]);
  const T length = T(2) * p[half_length] * sqrt(ratio);
  s.force[wheel::aligning] =
      T(-1) * moves * on * p[trail] * trail_at(p, slip[1]) * length * forwards * steady[1];
}

/// The vertical spring and the carcass store; all that the forces along the road do beyond is lost.
inline void tmeasy_energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
  using namespace tmeasy;
  const double* p = c.numbers();
  const double spring = brush_tyre::vertical<double>(p[brush_tyre::stiffness], 0, s.x[wheel::gap], 0).spring;
  e.stored = 0.5 * spring * spring / p[brush_tyre::stiffness] + s.states[stored];
  if (c.step > 0) e.lost = c.states[stored] - s.states[stored];
  e.dissipating[wheel::gap] = s.force[wheel::gap] + spring;
  for (int k = wheel::forth; k < s.count; ++k) e.dissipating[k] = s.force[k];
}

namespace tmeasy {
constexpr LawNumber force(std::string_view key, std::string_view about) {
  return {.key = key, .unit = "N", .about = about, .above = 0};
}
constexpr LawNumber slip(std::string_view key, std::string_view about) {
  return {.key = key, .about = about, .above = 0};
}
constexpr std::string_view about_growth = "at twice the load, over that at the load";
/// Of forces in proportion to the load, of slips alike at any load, where nothing is given.
constexpr LawNumber force_growth(std::string_view key) {
  return {.key = key, .about = about_growth, .otherwise = 2, .above = 0, .most = 3};
}
constexpr LawNumber slip_growth(std::string_view key) {
  return {.key = key, .about = about_growth, .otherwise = 1, .above = 0, .most = 1.9};
}
}  // namespace tmeasy

/// The numbers stand behind the vertical stiffness and the radius.
struct TmeasyTyre {
  static constexpr std::array<LawNumber, 30> numbers{{
      BrushTyre::number("damping"),
      BrushTyre::number("longitudinal_stiffness"),
      tmeasy::force("longitudinal_peak", "largest force along"),
      tmeasy::slip("longitudinal_peak_slip", "at which it is"),
      tmeasy::force("longitudinal_sliding", "force along where all slides"),
      tmeasy::slip("longitudinal_sliding_slip", "from which on all slides; above the peak's"),
      BrushTyre::number("cornering_stiffness"),
      tmeasy::force("lateral_peak", "largest force across"),
      tmeasy::slip("lateral_peak_slip", "at which it is"),
      tmeasy::force("lateral_sliding", "force across where all slides"),
      tmeasy::slip("lateral_sliding_slip", "from which on all slides; above the peak's"),
      tmeasy::force_growth("longitudinal_stiffness_growth"),
      tmeasy::force_growth("longitudinal_peak_growth"),
      tmeasy::slip_growth("longitudinal_peak_slip_growth"),
      tmeasy::force_growth("longitudinal_sliding_growth"),
      tmeasy::slip_growth("longitudinal_sliding_slip_growth"),
      tmeasy::force_growth("cornering_stiffness_growth"),
      tmeasy::force_growth("lateral_peak_growth"),
      tmeasy::slip_growth("lateral_peak_slip_growth"),
      tmeasy::force_growth("lateral_sliding_growth"),
      tmeasy::slip_growth("lateral_sliding_slip_growth"),
      BrushTyre::number("longitudinal_relaxation"),
      BrushTyre::number("lateral_relaxation"),
      BrushTyre::number("half_length"),
      {.key = "load", .unit = "N", .about = "at which these are so", .above = 0},
      {.key = "trail",
       .about = "lever of the force across at no slip, by the footprint's length",
       .otherwise = 1. / 6,
       .least = 0,
       .most = 0.5},
      {.key = "trail_zero_slip",
       .about = "slip across at which the trail is 0",
       .otherwise = 0.2,
       .above = 0},
      {.key = "trail_end_slip",
       .about = "slip across from which on the trail stays 0; above that",
       .otherwise = 0.5,
       .above = 0},
      BrushTyre::number("rolling_resistance"),
      BrushTyre::number("settling"),
  }};
  static std::string_view fault(std::span<const double> n) {
    const double* const p = n.data() - tmeasy::damping;
    for (const int first : {tmeasy::at_load, tmeasy::at_load + 5}) {
      const double* const at = p + first;
      const double* const by = at + (tmeasy::growth - tmeasy::at_load);
      // At no load, at twice the load, and so between.
      for (const double r : {0.0, 2.0})
        if (!(at[tmeasy::sliding_slip] * (1 + (by[tmeasy::sliding_slip] - 1) * (r - 1)) >
              at[tmeasy::peak_slip] * (1 + (by[tmeasy::peak_slip] - 1) * (r - 1))))
          return "all must slide from a slip on that is above the peak's, at any load";
    }
    if (!(p[tmeasy::trail_end] > p[tmeasy::trail_zero]))
      return "trail_end_slip must be above trail_zero_slip";
    return {};
  }
  /// tmeasy::slow.
  static void derived(std::span<const double>, double, std::vector<double>& behind) { behind.push_back(0); }
  static void set_scales(const Compiled& m, const ElementData& e, double* p) {
    p[tmeasy::slow] = slow_rolling(m, e, p[brush_tyre::stiffness]);
    set_settling(m, e, p[brush_tyre::stiffness], p[tmeasy::settling]);
  }
  static double slow_speed(const double* p) { return p[tmeasy::slow]; }
  static RollingSize rolling_size(std::span<const double> n) {
    return {1. / 3, n[tmeasy::half_length - tmeasy::damping]};
  }
  static constexpr LawInfo info{.name = "tmeasy_tyre",
                                .list = SpecList::tyres,
                                .numbers = numbers,
                                .states = 10,
                                .fault = fault,
                                .derived = derived,
                                .set_scales = set_scales,
                                .model = "tmeasy",
                                .slow_speed = slow_speed,
                                .rolling_size = rolling_size};

  template <class T>
  static void law(const LawContext<T>& c, ElementState<T>& s) {
    tmeasy_law(c, s);
  }
  static void energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
    tmeasy_energy(c, s, e);
  }
};

}  // namespace mimbre::forces
