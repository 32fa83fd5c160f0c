#pragma once
#include <cmath>

#include "math/dual.h"
#include "math/pack.h"

/// A tyre as a row of elastic bristles under a parabolic pressure; Pacejka, Tire and Vehicle Dynamics, 3rd
/// edition, 2012, section 3.2.
namespace mimbre::forces {

/// In ISO axes of the contact (x forward, y left, z up). The slip is the theoretical one, σ = −Vs / |Vr|: how
/// fast the tyre slides over the road, Vs, by how fast it rolls, Vr. With the practical slips of MagicInput
/// it is σx = κ / (1 + κ), σy = −tan α / (1 + κ).
template <class T>
struct BrushInput {
  T Fz;                ///< load, N; below 0 is as 0
  T sigma_x, sigma_y;  ///< slip
  T Cx, Cy;  ///< slip stiffness dF/dσ where there is none, N: 2 c a² of bristles of c N/m² each way
  T mu;      ///< friction
  T a;       ///< half of the contact's length, m
};

template <class T>
struct BrushOutput {
  T Fx, Fy;          ///< on the wheel, N
  T Mz;              ///< about the contact's centre, N m
  T xx, xy, yx, yy;  ///< dFx/dσx, dFx/dσy, dFy/dσx, dFy/dσy, N
};

/// Closed form of the sum over the bristles, (3.7) to (3.40). With s = (Cx σx, Cy σy), ρ = |s| / (3 μ Fz) and
/// λ = 1 − ρ, the share of the contact that adheres (0 from ρ = 1 on), what adheres pulls along s, and what
/// slides against its sliding, along w = |s| σ / |σ|:
///
///   F  = λ² s + ρ (1 − 2ρ/3) w,      F = μ Fz σ / |σ| where all slide
///   Mz = a (λ² − 4λ³/3) s_y − a ρ λ² w_y
///
/// Exact where Cx = Cy: s = w, |F| = μ Fz (1 − λ³), Mz = −a/3 λ³ s_y. Where they differ the bristles turn
/// while they begin to slide, which is left out: some percent of μ Fz.
template <class T>
BrushOutput<T> brush(const BrushInput<T>& in) {
  using std::sqrt;
  const T grip = select(in.Fz > T(0), T(in.mu * in.Fz), T(0));
  const auto holds = grip > T(0);
  const T limit = T(3) * select(holds, grip, T(1));
  const T sx = in.Cx * in.sigma_x, sy = in.Cy * in.sigma_y;
  const T pull = sqrt(T(sx * sx + sy * sy));
  const T slip = sqrt(T(in.sigma_x * in.sigma_x + in.sigma_y * in.sigma_y));
  const auto slips = pull > T(0);
  // Directions of slip and of how |s| grows; of none, where there is no slip.
  const T by_slip = select(slips, T(T(1) / select(slips, slip, T(1))), T(0));
  const T by_pull = select(slips, T(T(1) / select(slips, pull, T(1))), T(0));
  const T ex = in.sigma_x * by_slip, ey = in.sigma_y * by_slip;
  const T px = in.Cx * sx * by_pull, py = in.Cy * sy * by_pull;

  const T rho = pull / limit;
  const auto adheres = rho < T(1);
  const T held = select(adheres, T(T(1) - rho), T(0));
  // F = λ² s + share e of the whole, and derivatives of both factors by |s|.
  const T share = select(adheres, T(pull * rho * (T(1) - T(2) * rho / T(3))), T(limit / T(3)));
  const T held_slope = T(-2) * held / limit;
  const T share_slope = select(adheres, T(T(2) * rho * held), T(0));

  const T on = select(holds, T(1), T(0));
  BrushOutput<T> out;
  out.Fx = on * (held * held * sx + share * ex);
  out.Fy = on * (held * held * sy + share * ey);
  out.Mz = on * in.a * held * held * ((T(1) - T(4) * held / T(3)) * sy - rho * pull * ey);
  const T turn = share * by_slip;
  out.xx = on * (held * held * in.Cx + held_slope * px * sx + share_slope * px * ex + turn * ey * ey);
  out.xy = on * (held_slope * py * sx + share_slope * py * ex - turn * ex * ey);
  out.yx = on * (held_slope * px * sy + share_slope * px * ey - turn * ex * ey);
  out.yy = on * (held * held * in.Cy + held_slope * py * sy + share_slope * py * ey + turn * ex * ex);
  return out;
}

}  // namespace mimbre::forces
