#pragma once
#include "forces/magic/longitudinal.h"
#include "forces/magic/moments.h"
#include "forces/magic/vertical.h"
#include "math/elementary.h"

/// The Magic Formula of tyres, MF-Tyre 5.2, 6.1 and 6.2: forces and moments of steady slip between a wheel
/// and the road. Turn slip is left out. (What the numbers are: tyre_files/magic_numbers.h.)
namespace mimbre::forces {

/// On the wheel, at the contact's centre, in its ISO axes (MagicInput).
template <class T>
struct MagicOutput {
  T Fx, Fy;                    ///< N
  T Mx, My, Mz;                ///< N m
  T Kx, Ky;                    ///< dFx/dκ, N, and dFy/dα, N/rad, where there is no slip; Ky < 0
  T sigma_kappa, sigma_alpha;  ///< relaxation lengths, m, not below 0
  T trail;                     ///< pneumatic trail, m: the side force acts this far behind the centre
};

namespace magic {

/// Relaxation lengths. Since 6.1 slip stiffness by that of the standing tyre, (A3.9); in 5.2 formulas of
/// their own, with numbers PTX and PTY.
template <class T>
void relaxation(const Terms<T>& t, MagicOutput<T>& out) {
  using mimbre::exp;
  using mimbre::sin;
  const T* n = t.n;
  const auto stiffness = [&](Number nominal, Number first, Number second, Number pressure) {
    const T C =
        n[nominal] * (T(1) + n[first] * t.dfz + n[second] * t.dfz * t.dfz) * (T(1) + n[pressure] * t.dpi);
    return greatest(C, T(1e-3));
  };
  const T R = n[unloaded_radius];
  const T old_x = t.load / n[fnomin] * R * (n[ptx1] + n[ptx2] * t.dfz) * exp(T(-n[ptx3] * t.dfz)) * n[lsgkp];
  const T bend = select(n[pty2] == T(0), T(1), n[pty2]);
  const T old_y = n[pty1] * sin(T(T(2) * arctan(T(t.load / (bend * t.reference))))) *
                  (T(1) - n[pky3] * size_of(T(n[lgay] * t.sin_gamma))) * R * n[lfzo] * n[lsgal];
  const T new_x = size_of(out.Kx) / stiffness(longitudinal_stiffness, pcfx1, pcfx2, pcfx3);
  const T new_y = size_of(out.Ky) / stiffness(lateral_stiffness, pcfy1, pcfy2, pcfy3);
  out.sigma_kappa = greatest(select(is_old(t), old_x, new_x), T(0));
  out.sigma_alpha = greatest(select(is_old(t), old_y, new_y), T(0));
}

}  // namespace magic

/// `numbers` are magic::count, in the order of magic::Number. Finite at any slip, without load, at standstill
/// and backwards; where there is no load all is 0 but the relaxation lengths' limits.
template <class T>
MagicOutput<T> magic_formula(const T* numbers, const MagicInput<T>& in) {
  using namespace magic;
  const Terms<T> t = terms(numbers, in);
  const Longitudinal<T> x = longitudinal(t);
  const PureLateral<T> y = pure_lateral(t, t.sin_gamma);
  const T weight = lateral_weight(t), by_kappa = slip_side_force(t, y.friction);
  MagicOutput<T> out;
  out.Fx = x.force;
  out.Fy = weight * y.force + by_kappa;
  out.Kx = x.stiffness;
  out.Ky = y.stiffness;
  out.Mx = overturning(t, out.Fy);
  out.My = select(t.load > T(0), rolling_resistance(t, out.Fx), T(0));
  const Aligning<T> z = aligning(t, out.Fx, out.Fy, x.stiffness, y, weight, by_kappa);
  out.Mz = z.moment;
  out.trail = z.trail;
  relaxation(t, out);
  for (T* const value : {&out.Fx, &out.Fy, &out.Mx, &out.My, &out.Mz, &out.Kx, &out.Ky}) *value *= t.beyond;
  return out;
}

}  // namespace mimbre::forces
