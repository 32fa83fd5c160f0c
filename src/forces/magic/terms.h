#pragma once
#include <cmath>

#include "math/dual.h"
#include "math/elementary.h"
#include "math/pack.h"
#include "math/smooth.h"
#include "tyre_files/magic_numbers.h"

/// What all formulas of a Magic Formula tyre have in common. Numbers in brackets, as (4.E9), are equations of
/// Pacejka, Tire and Vehicle Dynamics, 3rd edition, 2012, section 4.3.2; those as (A54) are of Besselink,
/// Schmeitz and Pacejka, An improved Magic Formula/Swift tyre model that can handle inflation pressure
/// changes, Vehicle System Dynamics 48, 2010, which is nearer to MF-Tyre where the two differ.
namespace mimbre::forces {

/// How a wheel rolls and slides over the road, in ISO axes of the contact: x forward in the wheel's plane,
/// y to the left, z up, both x and y in the road's plane. (They are the W axes of TYDEX, which property files
/// are written for.) With Vsx, Vsy the velocity at which the tyre slides over the road and Vx that of the
/// wheel's centre:
///
///   kappa = −Vsx / |Vx|        > 0 when the wheel drives: Fx > 0
///   tan alpha = Vsy / |Vx|     > 0 when the wheel goes to the left of where it points: Fy < 0
///   gamma > 0                  leans to the right: Fy < 0
template <class T>
struct MagicInput {
  T Fz;          ///< load, N; below 0 is as 0
  T kappa;       ///< longitudinal slip
  T alpha;       ///< slip angle, rad
  T gamma;       ///< inclination, rad
  T dpi = T(0);  ///< (p − p₀) / p₀ of the pressure p and the nominal one, the number `nompres`
  T Vx;          ///< m/s; below 0 runs backwards
  T lmu = T(1);  ///< friction of this place of the road, by that of the road that the tyre was measured on
};

namespace magic {

template <class T>
T least(const T& a, const T& b) {
  return select(a < b, a, b);
}
template <class T>
T greatest(const T& a, const T& b) {
  return select(a > b, a, b);
}
template <class T>
T size_of(const T& a) {
  return select(a < T(0), T(-a), a);
}
/// +1 also of 0.
template <class T>
T sign_of(const T& a) {
  return select(a < T(0), T(-1), T(1));
}
template <class T>
T arctan(const T& a) {
  using mimbre::atan2;
  return atan2(a, T(1));
}

/// The angle whose sine or cosine the formulas take: C arctan{B x − E (B x − arctan B x)}.
template <class T>
T bent(const T& B, const T& C, const T& E, const T& x) {
  const T Bx = B * x;
  return C * arctan(T(Bx - E * (Bx - arctan(Bx))));
}

/// Nothing is divided by a smaller share of the nominal load, in N and N/rad.
constexpr double small_force = 2.5e-10;

/// By the speed of the measurement, LONGVL: below this, what changes sign with the direction of travel fades,
/// in place of V_low of (4.E6).
constexpr double slow = 0.012;

/// Polynomials of the load end here, by the scaled nominal load: property files are measured up to 2.5, and
/// far beyond friction falls below 0. What is loaded more has forces and moments in proportion to its load.
constexpr double most_load = 5;

template <class T>
struct Terms {
  const T* n;          ///< the tyre's numbers
  T load;              ///< Fz, not below 0, up to `most_load`
  T beyond;            ///< Fz over that load, 1 up to there
  T reference;         ///< LFZO times the nominal load, (4.E1)
  T dfz, dpi;          ///< relative deviations of load and pressure, (4.E2)
  T kappa, tan_alpha;  ///< tan_alpha: α* of (4.E3); of a tyre that runs backwards, too
  T gamma, sin_gamma;  ///< (4.E4)
  T along;             ///< cos′α of (4.E6) with the sign of Vx: −1 … 1, 0 at rest
  T speed;             ///< Vx
  T forwards;          ///< sign of Vx, without a jump
  T small;             ///< nothing is divided by less, N and N/rad
  T mu_x, mu_y;        ///< LMUX*, LMUY* of (4.E7)
};

template <class T>
Terms<T> terms(const T* n, const MagicInput<T>& in) {
  using mimbre::cos;
  using mimbre::sin;
  using std::sqrt;
  Terms<T> t;
  t.n = n;
  t.reference = n[lfzo] * n[fnomin];
  t.load = least(greatest(in.Fz, T(0)), T(T(most_load) * t.reference));
  t.beyond = select(in.Fz > t.load, T(in.Fz / t.load), T(1));
  t.dfz = (t.load - t.reference) / t.reference;
  t.dpi = in.dpi;
  t.kappa = in.kappa;
  t.tan_alpha = sin(in.alpha) / cos(in.alpha);
  t.gamma = in.gamma;
  t.sin_gamma = sin(in.gamma);
  // (4.E6) has V + V_low below: 0.6 % less at 60 km/h and 5 % less at 2 m/s. Here nothing fades above `slow`.
  const T across = t.tan_alpha * t.tan_alpha;
  t.speed = in.Vx;
  t.forwards = smooth::direction(in.Vx, T(T(slow) * n[longvl]));
  t.along = t.forwards / sqrt(T(T(1) + across));
  t.small = T(small_force) * n[fnomin];
  const T sliding = size_of(in.Vx) * sqrt(T(in.kappa * in.kappa + across));
  const T decay = in.lmu / (T(1) + n[lmuv] * sliding / n[longvl]);
  t.mu_x = n[lmux] * decay;
  t.mu_y = n[lmuy] * decay;
  return t;
}

/// The formulas of 5.2 in place of those since 6.1. A mask of lanes of a pack.
template <class T>
auto is_old(const Terms<T>& t) {
  return t.n[version] < T(60);
}

}  // namespace magic
}  // namespace mimbre::forces
