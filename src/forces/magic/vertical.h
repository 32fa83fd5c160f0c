#pragma once
#include "forces/magic/terms.h"

/// How a Magic Formula tyre carries its load, and how fast it rolls.
namespace mimbre::forces {

template <class T>
struct MagicVerticalInput {
  T deflection;            ///< by how much the loaded radius is below the unloaded one, m
  T rate;                  ///< of the deflection, m/s
  T omega = T(0);          ///< spin, rad/s; its sign does not matter
  T gamma = T(0);          ///< inclination, rad
  T dpi = T(0);            ///< as of MagicInput
  T Fx = T(0), Fy = T(0);  ///< which make the tyre softer, N
};

template <class T>
struct MagicVertical {
  T force;               ///< N, never pulls
  T stiffness, damping;  ///< its derivatives by deflection and rate, N/m and N s/m
};

/// Radius of the free tyre, which grows with spin, m, (A3.1) of the book's appendix 3.
template <class T>
T magic_free_radius(const T* n, const T& omega) {
  using namespace magic;
  const T R = n[unloaded_radius], v = omega * R / n[longvl];
  return R * (n[q_re0] + n[q_v1] * v * v);
}

/// Effective rolling radius, m: speed of a wheel that rolls freely by its spin, (A3.6).
template <class T>
T magic_rolling_radius(const T* n, const T& Fz, const T& omega, const T& dpi = T(0)) {
  using namespace magic;
  const T load = greatest(Fz, T(0)) / n[fnomin], C = n[vertical_stiffness] * (T(1) + n[pfz1] * dpi);
  return magic_free_radius(n, omega) -
         n[fnomin] / C * (n[dreff] * arctan(T(n[breff] * load)) + n[freff] * load);
}

/// Load by deflection ρ of the free tyre, (A3.3) with the camber of (4.E68):
///
///   Fz = {1 + QV2 |Ω| R₀/V₀ − (QFCX Fx/Fz₀)² − (QFCY Fy/Fz₀)²} (1 + PFZ1 dpi)
///        {(QFZ1 + QFZ3 γ²) ρ/R₀ + QFZ2 (ρ/R₀)²} Fz₀ + Kz dρ/dt
///
/// and the rim's stiffness where the tyre is pressed flat. No tyre is pressed in further than its radius: a
/// hub below the road is pushed out by the force that it had there. 5.2 is the case of QFZ1 alone. The camber
/// terms that only 6.2 has are left out.
template <class T>
MagicVertical<T> magic_vertical(const T* n, const MagicVerticalInput<T>& in) {
  using namespace magic;
  const T R = n[unloaded_radius], F = n[fnomin];
  const auto deeper = in.deflection > R;
  const T deflection = select(deeper, R, in.deflection);
  const T x = (deflection + magic_free_radius(n, in.omega) - R) / R;
  const T by_x = n[q_fcx] * in.Fx / F, by_y = n[q_fcy] * in.Fy / F;
  const T spin = n[q_v2] * size_of(in.omega) * R / n[longvl];
  const T factor = greatest(T(T(1) + spin - by_x * by_x - by_y * by_y), T(0)) * (T(1) + n[pfz1] * in.dpi) * F;
  const T linear = n[q_fz1] + n[q_fz3] * in.gamma * in.gamma;
  const T beyond = deflection - (R - n[rim_radius] - n[bottom_offst]);
  const auto flat = beyond > T(0);
  MagicVertical<T> z;
  z.force = factor * (linear * x + n[q_fz2] * x * x) + n[vertical_damping] * in.rate +
            select(flat, T(n[bottom_stiff] * beyond), T(0));
  z.stiffness = factor * (linear + T(2) * n[q_fz2] * x) / R + select(flat, n[bottom_stiff], T(0));
  z.damping = n[vertical_damping];
  const auto touches = x > T(0) && z.force > T(0);
  z.force = select(touches, z.force, T(0));
  z.stiffness = select(touches && !deeper, z.stiffness, T(0));
  z.damping = select(touches, z.damping, T(0));
  return z;
}

}  // namespace mimbre::forces
