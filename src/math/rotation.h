#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "math/choice.h"
#include "math/elementary.h"
#include "math/multiply_add.h"

/// Rotations: small helpers over Eigen, for any scalar. Rotation vectors are in radians.
namespace mimbre {

template <class T>
using Vec3 = Eigen::Matrix<T, 3, 1>;
template <class T>
using Mat3 = Eigen::Matrix<T, 3, 3>;
template <class T>
using Quat = Eigen::Matrix<T, 4, 1>;  ///< (w, x, y, z)

/// A v. Here as below the fused instruction counts: frames are turned into one another all the time.
template <class T>
Vec3<T> turned(const Mat3<T>& A, const Vec3<T>& v) {
  const auto row = [&](int i) {
    return multiply_add(A(i, 2), v[2], multiply_add(A(i, 1), v[1], T(A(i, 0) * v[0])));
  };
  return Vec3<T>(row(0), row(1), row(2));
}

/// Aᵀ v.
template <class T>
Vec3<T> turned_back(const Mat3<T>& A, const Vec3<T>& v) {
  const auto column = [&](int i) {
    return multiply_add(A(2, i), v[2], multiply_add(A(1, i), v[1], T(A(0, i) * v[0])));
  };
  return Vec3<T>(column(0), column(1), column(2));
}

/// A B.
template <class T>
Mat3<T> composed(const Mat3<T>& A, const Mat3<T>& B) {
  Mat3<T> out;
  for (int k = 0; k < 3; ++k) out.col(k) = turned<T>(A, Vec3<T>(B.col(k)));
  return out;
}

template <class T>
Mat3<T> skew(const Vec3<T>& a) {
  Mat3<T> m;
  m << T(0), -a[2], a[1], a[2], T(0), -a[0], -a[1], a[0], T(0);
  return m;
}

/// sin(φ)/φ, (1 − cos φ)/φ², (φ − sin φ)/φ³ and the derivatives of the last two divided by φ, as functions of
/// φ². Series below φ = 0.3 rad, where the closed forms lose digits.
template <class T>
struct RotationSeries {
  T sinc, a, b, a1, b1;
};
template <class Condition, class T>
RotationSeries<T> select(const Condition& condition, const RotationSeries<T>& x, const RotationSeries<T>& y) {
  return {select(condition, x.sinc, y.sinc), select(condition, x.a, y.a), select(condition, x.b, y.b),
          select(condition, x.a1, y.a1), select(condition, x.b1, y.b1)};
}
template <class T>
RotationSeries<T> rotation_series(const T& phi2) {
  using mimbre::cos, mimbre::sin, std::sqrt;
  const auto series = [&] {
    RotationSeries<T> s;
    const T x = phi2;
    s.sinc = T(1) - x / 6. * (T(1) - x / 20. * (T(1) - x / 42. * (T(1) - x / 72. * (T(1) - x / 110.))));
    s.a = T(0.5) *
          (T(1) - x / 12. * (T(1) - x / 30. * (T(1) - x / 56. * (T(1) - x / 90. * (T(1) - x / 132.)))));
    s.b = T(1. / 6) *
          (T(1) - x / 20. * (T(1) - x / 42. * (T(1) - x / 72. * (T(1) - x / 110. * (T(1) - x / 156.)))));
    s.a1 = T(-1. / 12) *
           (T(1) - x / 15. * (T(1) - x * (3. / 112) * (T(1) - x * (2. / 135) * (T(1) - x * (5. / 528)))));
    s.b1 =
        T(-1. / 60) * (T(1) - x / 21. * (T(1) - x / 48. * (T(1) - x * (2. / 165) * (T(1) - x * (5. / 624)))));
    return s;
  };
  const auto closed = [&] {
    RotationSeries<T> s;
    const T phi = sqrt(phi2), sp = sin(phi), cp = cos(phi);
    s.sinc = sp / phi;
    s.a = (T(1) - cp) / phi2;
    s.b = (phi - sp) / (phi2 * phi);
    s.a1 = (s.sinc - T(2) * s.a) / phi2;
    s.b1 = (s.a - T(3) * s.b) / phi2;
    return s;
  };
  return choose(phi2 < T(0.09), series, closed);
}

/// Rotation matrix of a rotation vector (exponential map).
template <class T>
Mat3<T> rotation_exp(const Vec3<T>& theta) {
  const RotationSeries<T> s = rotation_series<T>(theta.squaredNorm());
  const Mat3<T> k = skew<T>(theta);
  return Mat3<T>::Identity() + s.sinc * k + s.a * (k * k);
}

/// Left Jacobian: d/dt exp(θ~) = (J_l θ̇)~ exp(θ~).
template <class T>
Mat3<T> left_jacobian(const Vec3<T>& theta) {
  const RotationSeries<T> s = rotation_series<T>(theta.squaredNorm());
  const Mat3<T> k = skew<T>(theta);
  return Mat3<T>::Identity() + s.a * k + s.b * (k * k);
}

/// Rotation matrix of a unit quaternion.
template <class T>
Mat3<T> rotation_matrix(const Quat<T>& q) {
  const T w = q[0], x = q[1], y = q[2], z = q[3];
  Mat3<T> r;
  r << T(1) - T(2) * (y * y + z * z), T(2) * (x * y - w * z), T(2) * (x * z + w * y),  //
      T(2) * (x * y + w * z), T(1) - T(2) * (x * x + z * z), T(2) * (y * z - w * x),   //
      T(2) * (x * z - w * y), T(2) * (y * z + w * x), T(1) - T(2) * (x * x + y * y);
  return r;
}

/// Quaternion product p ∘ q.
template <class T>
Quat<T> quaternion_product(const Quat<T>& p, const Quat<T>& q) {
  Quat<T> r;
  r << p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],  //
      p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],   //
      p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],   //
      p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0];
  return r;
}

/// Unit quaternion of a rotation vector.
template <class T>
Quat<T> quaternion_exp(const Vec3<T>& theta) {
  using mimbre::cos, std::sqrt;
  const T half2 = theta.squaredNorm() / T(4);
  const T s = rotation_series<T>(half2).sinc / T(2);
  Quat<T> q;
  q << cos(sqrt(half2)), s * theta[0], s * theta[1], s * theta[2];
  return q;
}

/// Rotation vector (norm at most π) of a unit quaternion.
template <class T>
Vec3<T> quaternion_log(const Quat<T>& q) {
  using mimbre::atan2, std::sqrt;
  const Vec3<T> v(q[1], q[2], q[3]);
  const T n = v.norm();
  const T sign = select(q[0] < T(0), T(-1), T(1));
  return choose(
      n < T(1e-9), [&] { return Vec3<T>((T(2) * sign) * v); },
      [&] { return Vec3<T>((T(2) * atan2(n, sign * q[0]) / n * sign) * v); });
}

/// Unit quaternion of a rotation matrix.
inline Quat<double> quaternion_of(const Mat3<double>& r) {
  const Eigen::Quaterniond q(r);
  return Quat<double>(q.w(), q.x(), q.y(), q.z()).normalized();
}
/// Lane by lane, as the largest component decides how it is found; with a derivative, that of ½ ω ∘ q.
template <class T>
Quat<T> quaternion_of(const Mat3<T>& r) {
  Mat3<double> one;
  Quat<T> q;
  if constexpr (is_pack<T>) {
    for (int i = 0; i < T::lanes; ++i) {
      for (int k = 0; k < 9; ++k) one(k) = r(k)[i];
      const Quat<double> of = quaternion_of(one);
      for (int k = 0; k < 4; ++k) q[k][i] = of[k];
    }
  } else {
    Mat3<double> rate;
    for (int k = 0; k < 9; ++k) {
      one(k) = r(k).value;
      rate(k) = r(k).derivative;
    }
    const Quat<double> of = quaternion_of(one);
    const Mat3<double> spin = rate * one.transpose();
    const Quat<double> turned = quaternion_product<double>(
        Quat<double>(0, 0.25 * (spin(2, 1) - spin(1, 2)), 0.25 * (spin(0, 2) - spin(2, 0)),
                     0.25 * (spin(1, 0) - spin(0, 1))),
        of);
    for (int k = 0; k < 4; ++k) q[k] = T(of[k], turned[k]);
  }
  return q;
}

}  // namespace mimbre
