#pragma once
#include <numbers>

#include "forces/magic/lateral.h"
#include "math/elementary.h"

/// The moments of a Magic Formula tyre about the axes of the contact.
namespace mimbre::forces::magic {

/// Overturning moment, N m. (4.E69) has arctan² where MF-Tyre has the arctan of the square, which is taken,
/// with the terms of motorcycle tyres, QSX12 to QSX14.
template <class T>
T overturning(const Terms<T>& t, const T& Fy) {
  using mimbre::cos;
  using mimbre::sin;
  const T* n = t.n;
  const T g = t.gamma, load = t.load / n[fnomin], side = Fy / n[fnomin], grip = n[qsx6] * load;
  const T of_load = n[qsx1] * n[lvmx] - n[qsx2] * g * (T(1) + n[ppmx1] * t.dpi) + n[qsx3] * side +
                    n[qsx4] * cos(T(n[qsx5] * arctan(T(grip * grip)))) *
                        sin(T(n[qsx7] * g + n[qsx8] * arctan(T(n[qsx9] * side)))) +
                    n[qsx10] * arctan(T(n[qsx11] * load)) * g - n[qsx12] * g * size_of(g);
  return n[unloaded_radius] * n[lmx] * (t.load * of_load + Fy * (n[qsx13] + n[qsx14] * size_of(g)));
}

/// Rolling resistance, N m: against the wheel's rotation, so below 0 when it rolls forward, (A48). Fades
/// towards standstill. In 5.2 the load stands before the power: its QSY7, 0 by default, counts one more here.
template <class T>
T rolling_resistance(const Terms<T>& t, const T& Fx) {
  using mimbre::pow;
  const T* n = t.n;
  const T load = t.load / n[fnomin], v = t.speed / n[longvl], vv = v * v;
  const T size = n[qsy1] + n[qsy2] * Fx / n[fnomin] + n[qsy3] * size_of(v) + n[qsy4] * vv * vv +
                 (n[qsy5] + n[qsy6] * load) * t.gamma * t.gamma;
  // Neither base is 0, where powers have no slope.
  const T of_load = pow(greatest(load, T(1e-9)), n[qsy7]) * pow(greatest(T(T(1) + t.dpi), T(1e-3)), n[qsy8]);
  return -n[unloaded_radius] * n[fnomin] * n[lmy] * size * of_load * t.forwards;
}

template <class T>
struct Aligning {
  T moment;  ///< N m
  T trail;   ///< m, below 0 when the tyre runs backwards
};

/// Aligning moment of combined slip: −t F′y + Mzr + s Fx, (4.E71). Of pure slip it is (4.E31).
///
/// As MF-Tyre, against the book: camber with its sign in the trail, (A58), (A60); the nominal load without
/// LFZO in trail and arm s, (A56); equivalent slips through tangents, (A54), (A55). Force F′y of a tyre
/// without inclination; in 5.2 it is the tyre's own but for what longitudinal slip adds, `kappa_force`.
template <class T>
Aligning<T> aligning(const Terms<T>& t, const T& Fx, const T& Fy, const T& Kx, const PureLateral<T>& y,
                     const T& weight, const T& kappa_force) {
  using mimbre::cos;
  using mimbre::sin;
  using std::sqrt;
  const T* n = t.n;
  const T g = n[lgaz] * t.gamma, sg = n[lgaz] * t.sin_gamma, R = n[unloaded_radius];
  // No road has less friction; what is wanted is that nothing is divided by 0.
  const T mu = greatest(t.mu_y, T(1e-3));
  const T K = Kx / y.divisor, by_kappa = K * K * t.kappa * t.kappa;
  const auto with_kappa = [&](const T& slip) {
    constexpr double most = 1.5;  // rad: what is larger is full sliding, and its tangent would come around
    const T a = greatest(least(slip, T(most)), T(-most)), tangent = sin(a) / cos(a);
    return arctan(T(sqrt(T(tangent * tangent + by_kappa))));
  };

  // (4.E33) to (4.E44), the trail. The cosine is even, so that the slip's sign does not matter but in E.
  const T slip = t.tan_alpha + n[qhz1] + n[qhz2] * t.dfz + (n[qhz3] + n[qhz4] * t.dfz) * sg;
  const T B = (n[qbz1] + n[qbz2] * t.dfz + n[qbz3] * t.dfz * t.dfz) *
              (T(1) + n[qbz4] * g + n[qbz5] * size_of(g)) * n[lky] / mu;
  const T C = n[qcz1];
  const T D = (n[qdz1] + n[qdz2] * t.dfz) * (T(1) - n[ppz1] * t.dpi) *
              (T(1) + n[qdz3] * g + n[qdz4] * g * g) * t.load * R / n[fnomin] * n[ltr];
  const T E = least(T((n[qez1] + n[qez2] * t.dfz + n[qez3] * t.dfz * t.dfz) *
                      (T(1) + (n[qez4] + n[qez5] * sg) * T(2 / std::numbers::pi) * arctan(T(B * C * slip)))),
                    T(1));
  const T trail = D * cos(bent(B, C, E, with_kappa(slip))) * t.along;

  // (4.E36) to (4.E47), what is left where the trail has gone.
  const T residual_slip = t.tan_alpha + y.SH + y.SV / y.divisor;
  const T Br = n[qbz9] * n[lky] / mu + n[qbz10] * y.B * y.C;
  const T Dr =
      t.load * R *
      ((n[qdz6] + n[qdz7] * t.dfz) * n[lres] + ((n[qdz8] + n[qdz9] * t.dfz) * (T(1) + n[ppz2] * t.dpi) +
                                                (n[qdz10] + n[qdz11] * t.dfz) * size_of(sg)) *
                                                   sg * n[lkzc]) *
      t.mu_y * t.along;
  const T residual = Dr * cos(arctan(T(Br * with_kappa(residual_slip))));

  const T arm = R * (n[ssz1] + n[ssz2] * Fy / n[fnomin] + (n[ssz3] + n[ssz4] * t.dfz) * t.gamma) * n[ls];
  const T upright = pure_lateral(t, T(0)).force * weight;
  const T F = select(is_old(t), T(Fy - kappa_force), upright);
  return {T(-trail * F + residual + arm * Fx), trail};
}

}  // namespace mimbre::forces::magic
