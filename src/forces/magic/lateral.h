#pragma once
#include "forces/magic/terms.h"
#include "math/elementary.h"

/// The lateral force of a Magic Formula tyre.
namespace mimbre::forces::magic {

/// What pure side slip makes, and what the moments need of it.
template <class T>
struct PureLateral {
  T force;      ///< Fy0, N
  T stiffness;  ///< Kyα, dFy/dα where there is no slip, N/rad: below 0
  T divisor;    ///< K′yα, the same, never 0, (4.E39)
  T friction;   ///< μy
  T B, C;       ///< of the sine, (4.E21), (4.E26)
  T SH, SV;     ///< shifts of α* and of the force, (4.E27), (4.E29)
};

/// (4.E19) to (4.E30), of an inclination whose sine may be another than the wheel's.
///
/// 5.2 has no camber stiffness of its own, the numbers PKY6 and PKY7: there the number PHY3 shifts the slip.
template <class T>
PureLateral<T> pure_lateral(const Terms<T>& t, const T& of_camber) {
  using mimbre::atan2;
  using mimbre::sin;
  const T* n = t.n;
  const T g = n[lgay] * of_camber, gg = g * g;
  PureLateral<T> y;
  const T bend = (n[pky2] + n[pky5] * gg) * (T(1) + n[ppy2] * t.dpi);
  y.stiffness = n[pky1] * t.reference * (T(1) + n[ppy1] * t.dpi) * (T(1) - n[pky3] * size_of(g)) *
                sin(T(n[pky4] * arctan(T(t.load / (t.reference * bend))))) * n[lky];
  y.divisor = y.stiffness + sign_of(y.stiffness) * t.small;
  const T camber_force = t.load * (n[pvy3] + n[pvy4] * t.dfz) * g * n[lkyc] * t.mu_y;
  const T camber_stiffness = t.load * (n[pky6] + n[pky7] * t.dfz) * (T(1) + n[ppy5] * t.dpi) * n[lkyc];
  const T by_camber =
      select(is_old(t), T(n[phy3] * g * n[lkyc]), T((camber_stiffness * g - camber_force) / y.divisor));
  y.SH = (n[phy1] + n[phy2] * t.dfz) * n[lhy] + by_camber;
  y.SV = t.load * (n[pvy1] + n[pvy2] * t.dfz) * n[lvy] * t.mu_y + camber_force;
  const T slip = t.tan_alpha + y.SH;
  y.friction = greatest(T((n[pdy1] + n[pdy2] * t.dfz) * (T(1) + n[ppy3] * t.dpi + n[ppy4] * t.dpi * t.dpi) *
                          (T(1) - n[pdy3] * gg) * t.mu_y),
                        T(0));
  const T D = y.friction * t.load;
  const T E = least(T((n[pey1] + n[pey2] * t.dfz) *
                      (T(1) + n[pey5] * gg - (n[pey3] + n[pey4] * g) * sign_of(slip)) * n[ley]),
                    T(1));
  y.C = n[pcy1] * n[lcy];
  y.B = y.stiffness / (y.C * D + sign_of(D) * t.small);
  y.force = D * sin(bent(y.B, y.C, E, slip)) + y.SV;
  return y;
}

/// Gyκ, what longitudinal slip leaves of it, (4.E59) to (4.E65).
template <class T>
T lateral_weight(const Terms<T>& t) {
  using mimbre::cos;
  const T* n = t.n;
  const T B = (n[rby1] + n[rby4] * t.sin_gamma * t.sin_gamma) *
              cos(arctan(T(n[rby2] * (t.tan_alpha - n[rby3])))) * n[lyka];
  const T C = n[rcy1], E = least(T(n[rey1] + n[rey2] * t.dfz), T(1));
  const T shift = n[rhy1] + n[rhy2] * t.dfz;
  return cos(bent(B, C, E, T(t.kappa + shift))) / cos(bent(B, C, E, shift));
}

/// SVyκ, the side force that longitudinal slip makes by itself, N, (4.E66), (4.E67).
template <class T>
T slip_side_force(const Terms<T>& t, const T& friction) {
  using mimbre::cos;
  using mimbre::sin;
  const T* n = t.n;
  const T D = friction * t.load * (n[rvy1] + n[rvy2] * t.dfz + n[rvy3] * t.sin_gamma) *
              cos(arctan(T(n[rvy4] * t.tan_alpha)));
  return D * sin(T(n[rvy5] * arctan(T(n[rvy6] * t.kappa)))) * n[lvyka];
}

}  // namespace mimbre::forces::magic
