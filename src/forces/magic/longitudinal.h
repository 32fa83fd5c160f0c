#pragma once
#include "forces/magic/terms.h"
#include "math/elementary.h"

/// The longitudinal force of a Magic Formula tyre.
namespace mimbre::forces::magic {

template <class T>
struct Longitudinal {
  T force;      ///< N
  T stiffness;  ///< Kxκ, dFx/dκ where there is no slip, N
};

/// Slip stiffness Kxκ, (4.E15), N.
template <class T>
T slip_stiffness(const Terms<T>& t) {
  using mimbre::exp;
  const T* n = t.n;
  return t.load * (n[pkx1] + n[pkx2] * t.dfz) * exp(T(n[pkx3] * t.dfz)) *
         (T(1) + n[ppx1] * t.dpi + n[ppx2] * t.dpi * t.dpi) * n[lkx];
}

/// Fx0 of pure slip, (4.E9) to (4.E18).
template <class T>
Longitudinal<T> pure_longitudinal(const Terms<T>& t) {
  using mimbre::sin;
  const T* n = t.n;
  const T camber = n[lgax] * t.gamma;
  const T K = slip_stiffness(t);
  const T C = n[pcx1] * n[lcx];
  const T mu = (n[pdx1] + n[pdx2] * t.dfz) * (T(1) + n[ppx3] * t.dpi + n[ppx4] * t.dpi * t.dpi) *
               (T(1) - n[pdx3] * camber * camber) * t.mu_x;
  const T D = greatest(mu, T(0)) * t.load;  // > 0, (4.E12)
  const T slip = t.kappa + (n[phx1] + n[phx2] * t.dfz) * n[lhx];
  const T E = least(
      T((n[pex1] + n[pex2] * t.dfz + n[pex3] * t.dfz * t.dfz) * (T(1) - n[pex4] * sign_of(slip)) * n[lex]),
      T(1));
  const T B = K / (C * D + sign_of(D) * t.small);
  const T offset = t.load * (n[pvx1] + n[pvx2] * t.dfz) * n[lvx] * t.mu_x;
  return {T(D * sin(bent(B, C, E, slip)) + offset), K};
}

/// Gxα, what side slip leaves of it, (4.E51) to (4.E57).
template <class T>
T longitudinal_weight(const Terms<T>& t) {
  using mimbre::cos;
  const T* n = t.n;
  const T B = (n[rbx1] + n[rbx3] * t.sin_gamma * t.sin_gamma) * cos(arctan(T(n[rbx2] * t.kappa))) * n[lxal];
  const T C = n[rcx1], E = least(T(n[rex1] + n[rex2] * t.dfz), T(1)), shift = n[rhx1];
  return cos(bent(B, C, E, T(t.tan_alpha + shift))) / cos(bent(B, C, E, shift));
}

/// Fx, (4.E50).
template <class T>
Longitudinal<T> longitudinal(const Terms<T>& t) {
  Longitudinal<T> x = pure_longitudinal(t);
  x.force *= longitudinal_weight(t);
  return x;
}

}  // namespace mimbre::forces::magic
