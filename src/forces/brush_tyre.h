#pragma once
#include <cmath>

#include "forces/carcass.h"
#include "forces/element.h"
#include "forces/measure_wheel.h"

/// A tyre: a spring with a damper in the vertical direction, and a brush behind a carcass along and across
/// (forces/carcass.h). The force across acts behind the middle of the footprint, by the trail of the brush.
/// The tangents leave out what the forces along the road owe to the vertical one: that is not symmetric.
namespace mimbre::forces {

namespace brush_tyre {
/// Among the law's numbers.
constexpr int stiffness = 0, radius = 1, damping = 2, slip_stiffness = 3 /* along, across */, friction = 5,
              relaxation = 6 /* likewise */, half_length = 8, load = 9, resistance = 10, settling = 11;
/// States: the bend of the carcass along and across, m, by which the wheel is ahead of its footprint.
constexpr int bend = 0;

/// m/s: well below, the damper of the carcass counts, and rolling one way or the other is much the same.
constexpr double slow = 1;
constexpr double still = 0.1;

/// Push of the spring and of all, upwards, N, with the tangents of that.
template <class T>
struct Vertical {
  T spring, force, stiffness, damping;
};

template <class T>
Vertical<T> vertical(const T& spring, const T& damper, const T& gap, const T& rate) {
  Vertical<T> push;
  push.spring = select(gap < T(0), T(T(-1) * spring * gap), T(0));
  const T all = push.spring - damper * rate;
  // The damper does not hold the wheel down.
  const auto presses = gap < T(0) && all > T(0);
  push.force = select(presses, all, T(0));
  push.stiffness = select(presses, spring, T(0));
  push.damping = select(presses, damper, T(0));
  return push;
}

template <class T>
T carcass_stiffness(const T* p, int k) {
  return p[slip_stiffness + k] / p[relaxation + k];
}
}  // namespace brush_tyre

template <class T>
void brush_tyre_law(const LawContext<T>& c, ElementState<T>& s) {
  using namespace brush_tyre;
  using std::abs, std::sqrt;
  const int n = s.count;
  const T *p = c.numbers(), *before = c.states;
  for (int k = 0; k < n; ++k) s.force[k] = T(0);
  for (int k = 0; k < n * n; ++k) s.stiffness[k] = s.damping[k] = T(0);
  const Vertical<T> push = vertical<T>(p[stiffness], p[damping], s.x[wheel::gap], s.v[wheel::gap]);
  s.force[wheel::gap] = T(-1) * push.force;
  s.stiffness[0] = push.stiffness;
  s.damping[0] = push.damping;

  // At a load of its own, slip stiffnesses and the square of the footprint's length go with the load.
  const auto varies = p[load] > T(0);
  const T ratio = select(varies, T(push.force / select(varies, p[load], T(1))), T(1));
  const T turns = s.surroundings[wheel::spin];
  const T deep = select(s.x[wheel::gap] < T(0), T(-s.x[wheel::gap]), T(0));
  const T rolling = turns * (T(c.element.radius) - T(c.element.rolling) * deep);
  carcass::Patch<T> patch;
  patch.rolled = abs(rolling);
  patch.limit = push.force * p[friction] * s.surroundings[wheel::friction];
  const T speed = rolling / T(slow), calm = T(1) / (T(1) + speed * speed);
  T firm[2], viscous[2];
  for (int k = 0; k < 2; ++k) {
    firm[k] = carcass_stiffness(p, k);
    viscous[k] = firm[k] * p[settling] * calm;
    const T slip = s.v[wheel::forth + k];
    patch.pull[k] = firm[k] * (before[bend + k] + T(c.step) * slip) + viscous[k] * slip;
    patch.give[k] = T(c.step) * firm[k] + viscous[k];
    patch.stiffness[k] = p[slip_stiffness + k] * (ratio + T(1e-6));
  }
  const carcass::Held<T> held = carcass::hold(patch);
  for (int k = 0; k < 2; ++k) {
    s.force[wheel::forth + k] = held.force[k];
    const auto gives = patch.give[k] > T(0);
    const T bent = T(c.step) * held.force[k] + viscous[k] * before[bend + k];
    s.states[bend + k] = select(gives, T(bent / select(gives, patch.give[k], T(1))), before[bend + k]);
  }
  const T mixed = held.tangent[1] * sqrt(patch.give[0] * patch.give[1]);
  s.damping[wheel::forth * (n + 1)] = held.tangent[0] * patch.give[0];
  s.damping[wheel::across * (n + 1)] = held.tangent[2] * patch.give[1];
  s.damping[wheel::forth * n + wheel::across] = s.damping[wheel::across * n + wheel::forth] = mixed;

  const T forwards = rolling / sqrt(rolling * rolling + T(still * still));
  const T size = sqrt(rolling * rolling + T(still * still));
  const T lever = push.force * p[resistance] * p[radius];
  s.force[wheel::rolling] = lever * forwards;
  s.damping[wheel::rolling * (n + 1)] = lever * p[radius] * T(still * still) / (size * size * size);
  const T left = T(1) - held.used, length = p[half_length] * sqrt(ratio + T(1e-12));
  const T trail = length / T(3) * left * left * left / (left + held.used * held.used / T(3));
  s.force[wheel::aligning] = T(-1) * trail * forwards * held.force[1];
}

/// The vertical spring and the carcass store; all that the forces along the road do beyond is lost.
inline void brush_tyre_energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
  using namespace brush_tyre;
  const double* p = c.numbers();
  const double spring = vertical<double>(p[stiffness], 0, s.x[wheel::gap], 0).spring;
  e.stored = 0.5 * spring * spring / p[stiffness];
  for (int k = 0; k < 2; ++k) {
    const double firm = carcass_stiffness(p, k), was = c.states[bend + k], is = s.states[bend + k];
    e.stored += 0.5 * firm * is * is;
    e.lost -= 0.5 * firm * (is * is - was * was);
  }
  e.dissipating[wheel::gap] = s.force[wheel::gap] + spring;
  for (int k = wheel::forth; k < s.count; ++k) e.dissipating[k] = s.force[k];
}

}  // namespace mimbre::forces
