#pragma once
#include "dynamics/flexible.h"

/// How the amplitudes turn a frame. With θ = X_theta y: the rotation R(θ) from the undeformed to the deformed
/// axes, the map J(θ) from θ̇ to the angular velocity in the body, and the angular acceleration.
namespace mimbre {

/// Of a frame that turns with the slope s = along + θ in a plane: unit tangent, unit normal to it in the
/// plane, and |s|.
template <class T>
struct Slope {
  Vec3<T> tangent, across;
  T length;
  Slope(const FrameData& f, const Vec3<T>& theta) {
    const Vec3<T> s = f.along.template cast<T>() + theta;
    length = s.norm();
    tangent = s / length;
    across = f.normal.template cast<T>().cross(tangent);
  }
};

template <class T>
Mat3<T> turn_rotation(const FrameData& f, const Vec3<T>& theta) {
  switch (f.turn) {
    case FrameTurn::exponential:
      break;
    case FrameTurn::successive: {
      const auto about = [&](int axis) { return rotation_exp<T>(theta[axis] * Vec3<T>::Unit(axis)); };
      return about(0) * about(1) * about(2);
    }
    case FrameTurn::infinitesimal:
      return Mat3<T>::Identity() + skew<T>(theta);
    case FrameTurn::slope: {
      const Slope<T> s(f, theta);
      const Vec3<T> along = f.along.template cast<T>(), normal = f.normal.template cast<T>();
      const Vec3<T> across = normal.cross(along);
      return s.tangent * along.transpose() + s.across * across.transpose() + normal * normal.transpose();
    }
  }
  return rotation_exp<T>(theta);
}

template <class T>
Mat3<T> turn_jacobian(const FrameData& f, const Vec3<T>& theta) {
  switch (f.turn) {
    case FrameTurn::exponential:
      break;
    case FrameTurn::successive: {
      const Mat3<T> first = rotation_exp<T>(theta[0] * Vec3<T>::UnitX());
      Mat3<T> J;
      J << Vec3<T>::UnitX(), first.col(1), first * rotation_exp<T>(theta[1] * Vec3<T>::UnitY()).col(2);
      return J;
    }
    case FrameTurn::infinitesimal:
      return Mat3<T>::Identity();
    case FrameTurn::slope: {
      const Slope<T> s(f, theta);
      return f.normal.template cast<T>() * (s.across / s.length).transpose();
    }
  }
  return left_jacobian<T>(theta);
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

/// R, ω = J θ̇ and its derivative, for given rates and second derivatives of θ.
template <class T>
void turn_motion(const FrameData& f, const Vec3<T>& theta, const Vec3<T>& rate, const Vec3<T>& second,
                 Mat3<T>& rotation, Vec3<T>& omega, Vec3<T>& alpha) {
  if (f.turn == FrameTurn::exponential) {
    const RotationSeries<T> s = rotation_series<T>(theta.squaredNorm());
    const Mat3<T> k = skew<T>(theta), k2 = k * k;
    rotation = identity_and<T>(s.sinc, k, s.a, k2);
    const Mat3<T> jl = identity_and<T>(s.a, k, s.b, k2);
    const T phi_rate = theta.dot(rate);  // φ φ̇
    const Vec3<T> c1 = theta.cross(rate), c2 = theta.cross(c1);
    omega = jl * rate;
    alpha = jl * second + (s.a1 * phi_rate) * c1 + (s.b1 * phi_rate) * c2 + s.b * rate.cross(c1);
    return;
  }
  rotation = turn_rotation(f, theta);
  const Mat3<T> J = turn_jacobian(f, theta);
  omega = J * rate;
  alpha = J * second;
  if (f.turn == FrameTurn::successive) {
    const Vec3<T> w1 = rate[0] * J.col(0), w2 = rate[1] * J.col(1), w3 = rate[2] * J.col(2);
    alpha += w1.cross(w2) + (w1 + w2).cross(w3);
  } else if (f.turn == FrameTurn::slope) {
    // The slope's length and direction change together: d/dt (across · ṡ / |s|) = … − 2 (ṡ·t)(ṡ·n)/|s|².
    const Slope<T> s(f, theta);
    alpha -=
        T(2) * rate.dot(s.tangent) * rate.dot(s.across) / (s.length * s.length) * f.normal.template cast<T>();
  }
}

}  // namespace mimbre
