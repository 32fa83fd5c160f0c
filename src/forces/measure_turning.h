#pragma once
#include <algorithm>
#include <cmath>
#include <numbers>

#include "forces/element.h"
#include "math/elementary.h"
#include "spec/force_law.h"

/// How far frame b has turned against frame a, as three numbers that grow through any number of turns.
namespace mimbre {

/// Inverse of the left Jacobian of a rotation vector shorter than a turn: θ̇ = J⁻¹ ω.
template <class T>
Mat3<T> inverse_left_jacobian(const Vec3<T>& theta) {
  using std::sqrt;
  const T phi2 = theta.squaredNorm();
  const RotationSeries<T> s = rotation_series<T>(phi2);
  const Mat3<T> k = skew<T>(theta);
  // 1/φ² − (1 + cos φ)/(2 φ sin φ) = (1 − sinc/(2 a))/φ², with its series where digits would be lost.
  const T c = choose(
      phi2 < T(1e-3), [&] { return T(T(1. / 12) + phi2 * (T(1. / 720) + phi2 * T(1. / 30240))); },
      [&] { return T((T(1) - s.sinc / (T(2) * s.a)) / phi2); });
  return Mat3<T>::Identity() - T(0.5) * k + c * (k * k);
}

/// Up to half a turn it is the rotation vector. That has no meaning at a full turn, where every axis is as
/// good as any other, so that from half a turn on the axis n of then is kept, and turning τ about it and
/// tilting away from it are distinguished. With the unit quaternion p = (p₀, p⃗) of the rotation, pₙ = n · p⃗:
///
///     τ = 2 atan2(pₙ, p₀),   x = τ n + g(τ) (p⃗ − pₙ n).
///
/// For a rotation about n alone x and its derivative by the rotation are those of the rotation vector where
/// g(τ) = τ/sin ½τ. Here g is that but for terms of τ⁶ below half a turn, that at half a turn, and of the
/// period 2π: a tilt counts as much after a full turn as before it. So x and ∂x/∂ω pass continuously from one
/// measure to the other, and the torque of any energy of x is its gradient, at any angle. Only at a tilt of
/// half a turn τ is not known.
namespace turning {
/// States: the quaternion, of the sign in which it goes on from step to step; the rotation vector at which n
/// was kept (0: it is not yet); τ.
constexpr int quaternion = 0, kept = 4, angle = 7, count = turning_states;

/// p⃗'s smaller squares count as this: tilts of half a turn, and rotations by nothing.
constexpr double least_square = 1e-18;

template <class T>
struct Turned {
  Vec3<T> x;
  Mat3<T> by_spin;  ///< ẋ = by_spin · ω, both in the axes of a
};

template <class Condition, class T>
Turned<T> select(const Condition& condition, const Turned<T>& a, const Turned<T>& b) {
  return {mimbre::select(condition, a.x, b.x), mimbre::select(condition, a.by_spin, b.by_spin)};
}

/// The rotation vector, of any length below a full turn.
template <class T>
Turned<T> by_vector(const Quat<T>& p) {
  using mimbre::atan2, std::sqrt;
  const Vec3<T> v(p[1], p[2], p[3]);
  const T square = v.squaredNorm();
  const Vec3<T> theta = choose(
      square < T(least_square), [&] { return Vec3<T>(T(2) * v); },
      [&] {
        const T size = sqrt(square);
        return Vec3<T>((T(2) * atan2(size, p[0]) / size) * v);
      });
  return {theta, inverse_left_jacobian<T>(theta)};
}

/// 2 (1 + u/6 + 3u²/40 + last u³), the series of φ/sin ½φ by u = sin² ½φ, closed such that it has that value
/// at `size`: half a turn, and what a step went beyond that.
template <class T>
T last_coefficient(const T& size) {
  using mimbre::sin;
  constexpr double most = 4;
  const T half = T(0.5) * mimbre::select(size < T(most), size, T(most)), sine = sin(half), u = sine * sine;
  return (half / sine - T(1) - u * (T(1. / 6) + T(3. / 40) * u)) / (u * u * u);
}

/// `wound`: the rotation vector at which the axis was kept; `before`: τ when the step started.
template <class T>
Turned<T> about_axis(const Quat<T>& p, const Vec3<T>& wound, const T& before, T& tau) {
  using mimbre::atan2, std::round, std::sqrt;
  constexpr double period = 4 * std::numbers::pi;  // of a quaternion
  const T size = sqrt(wound.squaredNorm()), last = last_coefficient(size);
  const Vec3<T> n = wound / size, v(p[1], p[2], p[3]);
  const T along = n.dot(v), found = p[0] * p[0] + along * along,
          square = mimbre::select(found > T(least_square), found, T(least_square));
  tau = T(2) * atan2(along, p[0]);
  tau += T(period) * T(round((before - tau) / period));
  const Vec3<T> across = v - along * n;
  const T u = along * along / square, g = T(2) * (T(1) + u * (T(1. / 6) + u * (T(3. / 40) + u * last))),
          slope = T(2) * (T(1. / 6) + u * (T(2 * 3. / 40) + T(3) * u * last)) * along * p[0] / square;
  // τ̇ = t · ω
  const Vec3<T> t = (p[0] * p[0] * n + p[0] * v.cross(n) + along * v) / square;
  const Mat3<T> rate = T(0.5) * (p[0] * Mat3<T>::Identity() - skew<T>(v));  // of p⃗
  return {Vec3<T>(tau * n + g * across),
          Mat3<T>((n + slope * across) * t.transpose() + g * (rate - n * (n.transpose() * rate)))};
}

/// `before`: the states at the start of the step; writes those at its end.
template <class T>
Turned<T> measure(const Mat3<T>& rotation, const T* before, T* next) {
  using mimbre::select;
  using std::sqrt;
  Quat<T> p = quaternion_of(rotation);
  T same(0), begun(0);
  for (int k = 0; k < 4; ++k) {
    same += p[k] * before[quaternion + k];
    begun += before[quaternion + k] * before[quaternion + k];
  }
  const T side = select(begun > T(0), same, p[0]);
  p = select(side < T(0), T(-1), T(1)) * p;
  const Vec3<T> wound(before[kept], before[kept + 1], before[kept + 2]);
  T tau(0);
  const auto is_wound = wound.squaredNorm() > T(0);
  const Turned<T> turned = choose(
      is_wound, [&] { return about_axis(p, wound, before[angle], tau); }, [&] { return by_vector(p); });
  const auto winds = turned.x.squaredNorm() > T(std::numbers::pi * std::numbers::pi);
  for (int k = 0; k < 4; ++k) next[quaternion + k] = p[k];
  for (int k = 0; k < 3; ++k) next[kept + k] = select(is_wound, wound[k], select(winds, turned.x[k], T(0)));
  next[angle] = select(is_wound, tau, select(winds, T(sqrt(turned.x.squaredNorm())), T(0)));
  return turned;
}

/// By how much b has tilted from the axis that is kept, rad; 0 where there is none.
inline double tilt(const double* states) {
  const Vec3d wound(states[kept], states[kept + 1], states[kept + 2]);
  if (!(wound.squaredNorm() > 0)) return 0;
  const Vec3d n = wound.normalized(), v(states[1], states[2], states[3]);
  return 2 * mimbre::asin(std::min(1.0, n.cross(v).norm()));
}
}  // namespace turning

}  // namespace mimbre
