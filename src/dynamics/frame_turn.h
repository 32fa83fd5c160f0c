#pragma once
#include "dynamics/other_turns.h"

/// How the amplitudes y turn a frame. With θ = X_theta y: the rotation exp(θ~) from the undeformed to the
/// deformed axes, the map J(θ) from θ̇ to the angular velocity in the body, and the angular acceleration.
/// Frames that turn otherwise are in other_turns.h.
namespace mimbre {

/// R by the amplitudes.
template <class T>
Mat3<T> turn_rotation(const FrameData& f, const T* y) {
  if (f.turn != FrameTurn::exponential) return other_rotation(f, y);
  return rotation_exp<T>(times(f.X_theta, y));
}

/// 1 + a A + b B.
template <class T>
Mat3<T> identity_and(const T& a, const Mat3<T>& A, const T& b, const Mat3<T>& B) {
  Mat3<T> out;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i)
      out(i, j) = multiply_add(b, B(i, j), multiply_add(a, A(i, j), T(i == j ? 1 : 0)));
  return out;
}

/// R, ω and its derivative by the amplitudes and their derivatives.
template <class T>
void turn_motion(const FrameData& f, const T* y, const T* yd, const T* ydd, Mat3<T>& rotation, Vec3<T>& omega,
                 Vec3<T>& alpha) {
  if (f.turn != FrameTurn::exponential) return other_motion(f, y, yd, ydd, rotation, omega, alpha);
  const Vec3<T> theta = times(f.X_theta, y), rate = times(f.X_theta, yd), second = times(f.X_theta, ydd);
  const RotationSeries<T> s = rotation_series<T>(theta.squaredNorm());
  const Mat3<T> k = skew<T>(theta), k2 = k * k;
  rotation = identity_and<T>(s.sinc, k, s.a, k2);
  const Mat3<T> jl = identity_and<T>(s.a, k, s.b, k2);
  const T phi_rate = theta.dot(rate);  // φ φ̇
  const Vec3<T> c1 = theta.cross(rate), c2 = theta.cross(c1);
  omega = jl * rate;
  alpha = jl * second + (s.a1 * phi_rate) * c1 + (s.b1 * phi_rate) * c2 + s.b * rate.cross(c1);
}

/// out += (∂ω/∂ẏ)ᵀ moment, of a moment in body axes.
template <class T>
void add_moment(const FrameData& f, const T* y, const Vec3<T>& moment, T* out) {
  if (f.turn != FrameTurn::exponential) return add_other_moment(f, y, moment, out);
  const Vec3<T> theta = times(f.X_theta, y);
  add_transposed<T>(f.X_theta, turned_back<T>(left_jacobian<T>(theta), moment), out);
}

}  // namespace mimbre
