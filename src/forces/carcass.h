#pragma once
#include <array>
#include <cmath>

#include "forces/element.h"
#include "math/elementary.h"

/// The footprint of a tyre behind its carcass. The carcass is a spring with a damper along and across; the
/// footprint slips behind it by a law of friction. In series they give all that a tyre does over time:
/// on the roll the force follows the slip on a way of slip stiffness over carcass stiffness, the relaxation
/// length; a wheel that stands or is locked hangs on its carcass, without creeping, until its friction is
/// used up.
///
/// The law of friction is that of a brush with parabolic pressure (Pacejka, Tire and Vehicle Dynamics, 3rd
/// ed., 2012, 3.2): the force grows with the slip as L (1 − (1 − p)³), where p is the force K s that it would
/// be without sliding over 3 L, up to the limit L; beyond, all of it slides, and what slides more than that
/// does so straight against the force, whatever the stiffnesses are. The step is implicit (backward Euler).
namespace mimbre::forces::carcass {

/// What the two directions, along and across, are given.
template <class T>
struct Patch {
  T pull[2];        ///< N, that the carcass would pull if the footprint stuck over the step
  T resistance[2];  ///< N s/m, by which that falls with the velocity at which it slips
  T stiffness[2];   ///< N: force over slip, at small slip
  T rolled;         ///< m/s, at which the tread runs through the footprint
  T limit;          ///< N
};

template <class T>
struct FootprintForce {
  T force[2];
  T tangent[3];  ///< ∂force/∂pull: along, mixed, across; symmetric
  T used;        ///< p, at most 1
};

template <class T>
FootprintForce<T> footprint_force(const Patch<T>& patch) {
  using std::abs, mimbre::pow, std::sqrt;
  const auto some = [](const T& x) { return select(x > T(1e-300), x, T(1e-300)); };
  const auto length = [](const T& a, const T& b) { return T(sqrt(a * a + b * b + T(1e-300))); };
  const T limit = some(patch.limit);
  T ratio[2];
  for (int k = 0; k < 2; ++k) ratio[k] = patch.resistance[k] * patch.rolled / some(patch.stiffness[k]);

  // Part of it sticks: the force that the carcass pulls with, y q/(ratio + q), is that of the brush, where q
  // = 1 − p + p²/3 is its share of K s. Newton's method from below, where it does not overshoot.
  T all[2];  // where all of it has just begun to slide
  for (int k = 0; k < 2; ++k) all[k] = patch.pull[k] / (T(1) + T(3) * ratio[k]);
  const T least = length(all[0], all[1]);
  const auto slides = least >= limit;
  const T share = select(slides, T(0), T(T(1) - least / limit));
  T p = T(1) - select(share > T(0), T(pow(some(share), T(1. / 3))), T(0));
  for (int i = 0; i < 20; ++i) {
    const T q = T(1) - p + p * p / T(3), dq = T(-1) + p * T(2. / 3);
    T f[2], slope = T(0);
    for (int k = 0; k < 2; ++k) {
      const T sum = T(1) / (ratio[k] + q);
      f[k] = patch.pull[k] * q * sum;
      slope += f[k] * patch.pull[k] * ratio[k] * sum * sum;
    }
    const T force = length(f[0], f[1]), left = T(1) - p;
    const T off = force - limit * (T(1) - left * left * left);
    const T fall = slope / force * dq - T(3) * limit * left * left;
    const T next = p + off / select(fall < T(-1e-300), T(-fall), T(1));
    const auto goes_on = next - p > T(1e-14);
    p = select(goes_on, select(next < T(1), next, T(1)), p);
    if (!any(goes_on)) break;
  }
  const T q = T(1) - p + p * p / T(3);
  T soft[2];  // 1 over: force over pull
  for (int k = 0; k < 2; ++k) soft[k] = T(1) + ratio[k] / q;

  // All of it slides: pull = force (1 + 3 ratio + γ resistance), with the γ that keeps the limit.
  // Newton's method for 1/|force|, which is nearly straight (Moré and Sorensen, SIAM J. Sci. Stat. Comput. 4,
  // 1983): from below it does not overshoot either.
  T gamma = T(0);
  for (int i = 0; i < 20; ++i) {
    T square = T(1e-300), change = T(0);
    for (int k = 0; k < 2; ++k) {
      const T divided = T(1) / (T(1) + T(3) * ratio[k] + gamma * patch.resistance[k]);
      const T f = patch.pull[k] * divided;
      square += f * f;
      change += f * f * patch.resistance[k] * divided;
    }
    const T over = sqrt(square) / limit - T(1);
    const auto goes_on = slides && over > T(1e-14) && change > T(1e-300);
    gamma += select(goes_on, T(over * square / some(change)), T(0));
    if (!any(goes_on)) break;
  }
  for (int k = 0; k < 2; ++k)
    soft[k] = select(slides, T(T(1) + T(3) * ratio[k] + gamma * patch.resistance[k]), soft[k]);

  FootprintForce<T> shear;
  shear.used = select(slides, T(1), p);
  for (int k = 0; k < 2; ++k) shear.force[k] = patch.pull[k] / soft[k];
  const T size = length(shear.force[0], shear.force[1]);
  const T kept = select(size > limit, T(limit / size), T(1));
  for (int k = 0; k < 2; ++k) shear.force[k] *= kept;

  // Along the force it grows by less than across it: not at all where all slides.
  const T left = T(1) - shear.used, mean = T(0.5) * (ratio[0] + ratio[1]);
  const T radial = left * left / some(T(left * left + mean)), secant = q / (q + mean);
  const T lost = select(slides, T(1), T(T(1) - radial / secant));
  T relaxed[2], weight = T(1e-300);
  for (int k = 0; k < 2; ++k) {
    relaxed[k] = shear.force[k] / soft[k];
    weight += shear.force[k] * relaxed[k];
  }
  shear.tangent[0] = T(1) / soft[0] - lost * relaxed[0] * relaxed[0] / weight;
  shear.tangent[1] = T(-1) * lost * relaxed[0] * relaxed[1] / weight;
  shear.tangent[2] = T(1) / soft[1] - lost * relaxed[1] * relaxed[1] / weight;
  return shear;
}

/// A wheel over a step; arrays are along and across.
template <class T>
struct Wheel {
  T spring[2];                    ///< stiffness of the carcass, N/m
  T settling;                     ///< s: its damping over that, of a wheel that stands
  T stiffness[2], rolled, limit;  ///< as of Patch
  const T* bend;                  ///< at the step's start: by how much the wheel is ahead of its footprint, m
  const T* rate;                  ///< m/s, at which it slips over the road
  std::array<T, 2> gone{T(0), T(0)};  ///< m, by which it has slipped where the step is 0
};

template <class T>
struct Followed {
  FootprintForce<T> shear;
  T resistance[2];
  T slip[2];  ///< m/s, of the footprint
  T bend[2];  ///< at the step's end
};

/// The damper counts while the way that rolls through the footprint in the settling time is well below this
/// share of the relaxation length: to a step of the slip it never answers at once by more than half of this
/// share of the steady force.
constexpr double slow = 0.05;

/// Step 0: the bend is what a wheel that is moved to here has as far as its friction holds it, and stays
/// where it is not moved.
template <class T>
Followed<T> follow(const Wheel<T>& w, double step) {
  using std::sqrt;
  Patch<T> patch;
  T viscous[2], bend[2];
  for (int k = 0; k < 2; ++k) bend[k] = w.bend[k] + w.gone[k];
  if (step <= 0) {
    T square(1e-300), moved(0);
    for (int k = 0; k < 2; ++k) {
      square += w.spring[k] * bend[k] * w.spring[k] * bend[k];
      moved += w.gone[k] * w.gone[k];
    }
    const auto slides = select(moved > T(0), square, T(0)) > w.limit * w.limit;
    const T share = select(slides, T(w.limit / sqrt(square)), T(1));
    for (int k = 0; k < 2; ++k) bend[k] *= share;
  }
  for (int k = 0; k < 2; ++k) {
    const T way = w.rolled * w.settling * w.spring[k] / (T(slow) * w.stiffness[k]);
    viscous[k] = w.spring[k] * w.settling / (T(1) + way * way);
    patch.pull[k] = w.spring[k] * (bend[k] + T(step) * w.rate[k]) + viscous[k] * w.rate[k];
    patch.resistance[k] = T(step) * w.spring[k] + viscous[k];
    patch.stiffness[k] = w.stiffness[k];
  }
  patch.rolled = w.rolled;
  patch.limit = w.limit;
  Followed<T> f;
  f.shear = footprint_force(patch);
  for (int k = 0; k < 2; ++k) {
    f.resistance[k] = patch.resistance[k];
    const auto resists = patch.resistance[k] > T(0);
    const T inverse = T(1) / select(resists, patch.resistance[k], T(1));
    const T bent = T(step) * f.shear.force[k] + viscous[k] * bend[k];
    f.bend[k] = select(resists, T(bent * inverse), bend[k]);
    f.slip[k] = select(resists, T((patch.pull[k] - f.shear.force[k]) * inverse), w.rate[k]);
  }
  return f;
}

/// Tangents of the two components from `first` on of an element.
template <class T>
void put_tangents(const Followed<T>& f, int first, ElementState<T>& s) {
  using std::sqrt;
  const int n = s.count, second = first + 1;
  s.damping[first * (n + 1)] = f.shear.tangent[0] * f.resistance[0];
  s.damping[second * (n + 1)] = f.shear.tangent[2] * f.resistance[1];
  s.damping[first * n + second] = s.damping[second * n + first] =
      f.shear.tangent[1] * sqrt(f.resistance[0] * f.resistance[1]);
}

}  // namespace mimbre::forces::carcass
