#pragma once
#include "dynamics/flexible.h"
#include "dynamics/section_axes.h"

/// How the amplitudes turn frames otherwise than by exp(θ~), θ = X_theta y (FrameTurn): by other maps of θ,
/// with the direction of a beam by absolute nodal coordinates, or with its section. A frame that turns with a
/// section has no θ: its two directions are amplitudes.
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

// Not of a section.

/// R(θ).
template <class T>
Mat3<T> rotation_by(const FrameData& f, const Vec3<T>& theta) {
  switch (f.turn) {
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
    case FrameTurn::exponential:
    case FrameTurn::section:
      break;
  }
  return rotation_exp<T>(theta);
}

/// J(θ): ω = J θ̇.
template <class T>
Mat3<T> jacobian_by(const FrameData& f, const Vec3<T>& theta) {
  switch (f.turn) {
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
    case FrameTurn::exponential:
    case FrameTurn::section:
      break;
  }
  return left_jacobian<T>(theta);
}

/// The part of the angular acceleration that is quadratic in θ̇.
template <class T>
Vec3<T> quadratic_by(const FrameData& f, const Vec3<T>& theta, const Vec3<T>& rate, const Mat3<T>& J) {
  switch (f.turn) {
    case FrameTurn::successive: {
      const Vec3<T> w1 = rate[0] * J.col(0), w2 = rate[1] * J.col(1), w3 = rate[2] * J.col(2);
      return w1.cross(w2) + (w1 + w2).cross(w3);
    }
    case FrameTurn::slope: {
      // The slope's length and direction change together: d/dt (across · ṡ / |s|) = … − 2 (ṡ·t)(ṡ·n)/|s|².
      const Slope<T> s(f, theta);
      return f.normal.template cast<T>() *
             (T(-2) * rate.dot(s.tangent) * rate.dot(s.across) / (s.length * s.length));
    }
    case FrameTurn::direction:
      return Direction<T>(f, theta).quadratic(rate);
    case FrameTurn::exponential:
    case FrameTurn::infinitesimal:
    case FrameTurn::section:
      break;
  }
  return Vec3<T>::Zero();
}

// Of all, as turn_rotation() and the others of frame_turn.h.

template <class T>
Mat3<T> other_rotation(const FrameData& f, const T* y) {
  if (f.turn != FrameTurn::section) return rotation_by<T>(f, times(f.X_theta, y));
  const Mat3<T> Q = line_axes<T>(f);
  const SectionAxes<T> s = section_axes(f, y);
  Mat3<T> axes;
  axes << s.e[0], s.e[1], s.e[2];
  return Q * axes * Q.transpose();
}

template <class T>
void other_motion(const FrameData& f, const T* y, const T* yd, const T* ydd, Mat3<T>& rotation,
                  Vec3<T>& omega, Vec3<T>& alpha) {
  rotation = other_rotation<T>(f, y);
  if (f.turn != FrameTurn::section) {
    const Vec3<T> theta = times(f.X_theta, y), rate = times(f.X_theta, yd), second = times(f.X_theta, ydd);
    const Mat3<T> J = jacobian_by<T>(f, theta);
    omega = J * rate;
    alpha = J * second + quadratic_by<T>(f, theta, rate, J);
    return;
  }
  const Mat3<T> Q = line_axes<T>(f);
  const SectionAxes<T> s = section_axes(f, y);
  const auto change = [&](int which, const T* by) { return section_direction(f, which, by, true); };
  omega = Q * s.global(s.turn(change(0, yd), change(1, yd)));
  alpha = Q * s.global(s.angular_acceleration(change(0, yd), change(1, yd), change(0, ydd), change(1, ydd)));
}

template <class T>
void add_other_moment(const FrameData& f, const T* y, const Vec3<T>& moment, T* out) {
  if (f.turn != FrameTurn::section) {
    const Mat3<T> J = jacobian_by<T>(f, times(f.X_theta, y));
    return add_transposed<T>(f.X_theta, turned_back<T>(J, moment), out);
  }
  Vec3<T> on[2] = {Vec3<T>::Zero(), Vec3<T>::Zero()};
  const SectionAxes<T> s = section_axes(f, y);
  s.add_moment(s.local(line_axes<T>(f).transpose() * moment), on[0], on[1]);
  for (std::size_t k = 0; k < 6; ++k)
    if (const int at = f.directions[k]; at >= 0) out[at] += on[k / 3][static_cast<int>(k % 3)];
}

/// A ∂ω/∂ẏ: three rows of so many columns.
template <class T>
void other_turn_rows(const FrameData& f, const T* y, const Mat3<T>& A, int stride, T* out) {
  if (f.turn != FrameTurn::section) {
    const Mat3<T> J = A * jacobian_by<T>(f, times(f.X_theta, y));
    for (int r = 0; r < 3; ++r)
      for (int k = 0; k < stride; ++k)
        out[r * stride + k] = multiply_add(
            J(r, 2), f.X_theta(2, k), multiply_add(J(r, 1), f.X_theta(1, k), T(J(r, 0) * f.X_theta(0, k))));
    return;
  }
  for (int k = 0; k < 3 * stride; ++k) out[k] = T(0);
  const Mat3<T> Q = A * line_axes<T>(f);
  const SectionAxes<T> s = section_axes(f, y);
  for (int k = 0; k < 6; ++k) {
    const int at = f.directions[static_cast<std::size_t>(k)];
    if (at < 0) continue;
    Vec3<T> by[2] = {Vec3<T>::Zero(), Vec3<T>::Zero()};
    by[k / 3][k % 3] = T(1);
    const Vec3<T> turn = Q * s.global(s.turn(by[0], by[1]));
    for (int r = 0; r < 3; ++r) out[r * stride + at] = turn[r];
  }
}

// Of doubles they are in other_turns.cpp (see there).
Mat3<double> other_rotation(const FrameData& f, const double* y);
void other_motion(const FrameData& f, const double* y, const double* yd, const double* ydd,
                  Mat3<double>& rotation, Vec3<double>& omega, Vec3<double>& alpha);
void add_other_moment(const FrameData& f, const double* y, const Vec3<double>& moment, double* out);
void other_turn_rows(const FrameData& f, const double* y, const Mat3<double>& A, int stride, double* out);

}  // namespace mimbre
