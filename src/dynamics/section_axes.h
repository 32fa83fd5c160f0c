#pragma once
#include "forces/motion.h"

namespace mimbre {

/// Axes of a cross-section of a beam whose directions y and z are coordinates and so may stretch and shear:
/// e1 at right angles to both, e3 along z, e2 = e3 × e1.
template <class T>
struct SectionAxes {
  Vec3<T> e[3];
  T z_length, y2, y3;  ///< |z|; y along e2 and e3

  SectionAxes(const Vec3<T>& y, const Vec3<T>& z) {
    const Vec3<T> across = y.cross(z);
    e[0] = across / across.norm();
    z_length = z.norm();
    e[2] = z / z_length;
    e[1] = e[2].cross(e[0]);
    y2 = e[1].dot(y);
    y3 = e[2].dot(y);
  }

  /// A vector in these axes.
  Vec3<T> local(const Vec3<T>& v) const { return Vec3<T>(e[0].dot(v), e[1].dot(v), e[2].dot(v)); }
  Vec3<T> global(const Vec3<T>& v) const { return e[0] * v[0] + e[1] * v[1] + e[2] * v[2]; }

  /// The angle, in these axes, by which they turn where y and z change by so much: from e3 along z, and
  /// e1 · y = 0.
  Vec3<T> turn(const Vec3<T>& by_y, const Vec3<T>& by_z) const {
    const T second = e[0].dot(by_z) / z_length;
    return Vec3<T>(-e[1].dot(by_z) / z_length, second, (y3 * second - e[0].dot(by_y)) / y2);
  }

  /// The transpose of turn(): adds what a moment in these axes is on y and z.
  void add_moment(const Vec3<T>& moment, Vec3<T>& on_y, Vec3<T>& on_z) const {
    on_z += e[0] * ((moment[1] + moment[2] * (y3 / y2)) / z_length) - e[1] * (moment[0] / z_length);
    on_y -= e[0] * (moment[2] / y2);
  }

  /// Angular acceleration, in these axes, from velocities and accelerations of y and z.
  Vec3<T> angular_acceleration(const Vec3<T>& yd, const Vec3<T>& zd, const Vec3<T>& ydd,
                               const Vec3<T>& zdd) const {
    const Vec3<T> w = turn(yd, zd), a = turn(ydd, zdd), in_y = local(yd), in_z = local(zd);
    const T stretch = in_z[2] / z_length;
    // ėᵢ·ẋ = ω·(eᵢ × ẋ).
    const T e0z = w[2] * in_z[1] - w[1] * in_z[2], e1z = w[0] * in_z[2] - w[2] * in_z[0],
            e0y = w[2] * in_y[1] - w[1] * in_y[2];
    const T y2d = in_y[1] + w[0] * y3, y3d = in_y[2] - w[0] * y2;
    const T second = e0z / z_length - w[1] * stretch;
    return a + Vec3<T>(-e1z / z_length - w[0] * stretch, second,
                       (y3d * w[1] + y3 * second - e0y - w[2] * y2d) / y2);
  }
};

}  // namespace mimbre
