#pragma once
#include "dynamics/flexible.h"
#include "dynamics/section_axes.h"

/// How the amplitudes turn a frame. With θ = X_theta y: the rotation R(θ) from the undeformed to the deformed
/// axes, the map J(θ) from θ̇ to the angular velocity in the body, and the angular acceleration. A frame that
/// turns with a section has no θ: its two directions are amplitudes, and J is that of SectionAxes.
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

/// Of a frame that turns with the direction s = a + θ from the undeformed one, a, by the shortest way: unit
/// tangent t, a × t, |s|, and 1 + a·t, which is 0 where there is no shortest way.
template <class T>
struct Direction {
  Vec3<T> undeformed, tangent, across;
  T length, opening;
  Direction(const FrameData& f, const Vec3<T>& theta) : undeformed(f.along.template cast<T>()) {
    const Vec3<T> s = undeformed + theta;
    length = s.norm();
    tangent = s / length;
    across = undeformed.cross(tangent);
    opening = T(1) + undeformed.dot(tangent);
  }
  Mat3<T> rotation() const {
    return (opening - T(1)) * Mat3<T>::Identity() + skew<T>(across) + across * (across / opening).transpose();
  }
  /// ω = t × ṫ − t (a × t)·ṫ/(1 + a·t).
  Mat3<T> jacobian() const { return (skew<T>(tangent) - tangent * (across / opening).transpose()) / length; }
  /// The part of the angular acceleration that is quadratic in the rate of s.
  Vec3<T> quadratic(const Vec3<T>& rate) const {
    const T stretch = tangent.dot(rate) / length;
    const Vec3<T> turning = rate / length - tangent * stretch;
    const T spin = across.dot(rate) / (length * opening);
    const T spin_rate = undeformed.cross(turning).dot(rate) / (length * opening) -
                        spin * (stretch + undeformed.dot(turning) / opening);
    return turning.cross(rate) / length - tangent.cross(rate) * (stretch / length) - turning * spin -
           tangent * spin_rate;
  }
};

/// Columns: x, y and z of the undeformed line, body axes.
template <class T>
Mat3<T> line_axes(const FrameData& f) {
  Mat3d axes;
  axes << f.along, f.normal.cross(f.along), f.normal;
  return axes.template cast<T>();
}

/// A direction of the frame's section, in the axes of the line: amplitudes of its y (0) or z (1) and the
/// undeformed one, or their rates.
template <class T>
Vec3<T> section_direction(const FrameData& f, int which, const T* y, bool rate) {
  Vec3<T> out = Vec3<T>::Zero();
  if (!rate) out[1 + which] = T(1);
  for (int c = 0; c < 3; ++c)
    if (const int at = f.directions[static_cast<std::size_t>(3 * which + c)]; at >= 0) out[c] += y[at];
  return out;
}
template <class T>
SectionAxes<T> section_axes(const FrameData& f, const T* y) {
  return {section_direction(f, 0, y, false), section_direction(f, 1, y, false)};
}

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
    case FrameTurn::direction:
      return Direction<T>(f, theta).rotation();
    case FrameTurn::section:
      break;
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
    case FrameTurn::direction:
      return Direction<T>(f, theta).jacobian();
    case FrameTurn::section:
      break;
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
  } else if (f.turn == FrameTurn::direction) {
    alpha += Direction<T>(f, theta).quadratic(rate);
  }
}

/// R by the amplitudes y.
template <class T>
Mat3<T> turn_rotation(const FrameData& f, const T* y) {
  if (f.turn != FrameTurn::section) return turn_rotation<T>(f, times(f.X_theta, y));
  const Mat3<T> Q = line_axes<T>(f);
  const SectionAxes<T> s = section_axes(f, y);
  Mat3<T> axes;
  axes << s.e[0], s.e[1], s.e[2];
  return Q * axes * Q.transpose();
}

/// R, ω and its derivative by the amplitudes and their derivatives.
template <class T>
void turn_motion(const FrameData& f, const T* y, const T* yd, const T* ydd, Mat3<T>& rotation, Vec3<T>& omega,
                 Vec3<T>& alpha) {
  if (f.turn != FrameTurn::section)
    return turn_motion<T>(f, times(f.X_theta, y), times(f.X_theta, yd), times(f.X_theta, ydd), rotation,
                          omega, alpha);
  rotation = turn_rotation<T>(f, y);
  const Mat3<T> Q = line_axes<T>(f);
  const SectionAxes<T> s = section_axes(f, y);
  const auto change = [&](int which, const T* by) { return section_direction(f, which, by, true); };
  omega = Q * s.global(s.turn(change(0, yd), change(1, yd)));
  alpha = Q * s.global(s.angular_acceleration(change(0, yd), change(1, yd), change(0, ydd), change(1, ydd)));
}

/// out += (∂ω/∂ẏ)ᵀ moment, of a moment in body axes.
template <class T>
void add_moment(const FrameData& f, const T* y, const Vec3<T>& moment, T* out) {
  if (f.turn != FrameTurn::section)
    return add_transposed<T>(f.X_theta,
                             turned_back<T>(turn_jacobian<T>(f, Vec3<T>(times(f.X_theta, y))), moment), out);
  Vec3<T> on[2] = {Vec3<T>::Zero(), Vec3<T>::Zero()};
  const SectionAxes<T> s = section_axes(f, y);
  s.add_moment(s.local(line_axes<T>(f).transpose() * moment), on[0], on[1]);
  for (std::size_t k = 0; k < 6; ++k)
    if (const int at = f.directions[k]; at >= 0) out[at] += on[k / 3][static_cast<int>(k % 3)];
}

/// ∂ω/∂ẏ of a frame that turns with a section, by its six directions' amplitudes, body axes.
template <class T>
Eigen::Matrix<T, 3, 6> section_turns(const FrameData& f, const T* y) {
  const Mat3<T> Q = line_axes<T>(f);
  const SectionAxes<T> s = section_axes(f, y);
  Eigen::Matrix<T, 3, 6> out;
  for (int k = 0; k < 6; ++k) {
    Vec3<T> by[2] = {Vec3<T>::Zero(), Vec3<T>::Zero()};
    by[k / 3][k % 3] = T(1);
    out.col(k) = Q * s.global(s.turn(by[0], by[1]));
  }
  return out;
}

}  // namespace mimbre
