#pragma once
#include "compile/compiled.h"
#include "math/rotation.h"

/// Positions and increments in their tangent space: sums, but for the unit quaternions of some joints.
namespace mimbre::relative {

/// out = q moved by the increment x; out may be q.
template <class T>
void retract(const Compiled& m, const T* q, const T* x, T* out) {
  for (const BodyData& b : m.bodies) {
    const JointInfo& info = joint_info(b.joint);
    const T* qb = q + b.q;
    const T* xb = x + b.v;
    T* ob = out + b.q;
    const int plain = info.quaternion < 0 ? info.velocities : info.rotation;
    for (int k = 0; k < plain; ++k) ob[k] = qb[k] + xb[k];
    if (info.quaternion >= 0) {
      const T* p = qb + info.quaternion;
      const T* t = xb + info.rotation;
      Quat<T> r = quaternion_product<T>(Quat<T>(p[0], p[1], p[2], p[3]),
                                        quaternion_exp<T>(Vec3<T>(t[0], t[1], t[2])));
      r /= r.norm();
      for (int k = 0; k < 4; ++k) ob[info.quaternion + k] = r[k];
    }
    for (int k = 0; k < b.modes; ++k)
      ob[info.positions + k] = qb[info.positions + k] + xb[info.velocities + k];
  }
}

/// How the increment x changes at velocities v: of rotations dexp⁻¹(x) v = v + ½ x × v + c x × (x × v), c =
/// (1 − φ/2 cot φ/2)/φ², φ = |x| (Iserles, Munthe-Kaas, Nørsett, Zanna 2000, 2.45).
template <class T>
void increment_rate(const Compiled& m, const T* x, const T* v, T* rate) {
  for (int k = 0; k < m.velocities; ++k) rate[k] = v[k];
  for (const BodyData& b : m.bodies) {
    const JointInfo& info = joint_info(b.joint);
    if (info.quaternion < 0) continue;
    const int at = b.v + info.rotation;
    const Vec3<T> u(x[at], x[at + 1], x[at + 2]), w(v[at], v[at + 1], v[at + 2]);
    const T y = u.squaredNorm();
    const T c = choose(
        y < T(0.09),
        [&] {
          return T(1. / 12) *
                 (T(1) + y / 60. * (T(1) + y / 42. * (T(1) + y / 40. * (T(1) + y * (5. / 198)))));
        },
        [&] {
          const RotationSeries<T> s = rotation_series<T>(y);
          return T((T(1) - s.sinc / (T(2) * s.a)) / y);
        });
    const Vec3<T> turned = u.cross(w);
    const Vec3<T> sum = w + T(0.5) * turned + c * u.cross(turned);
    for (int k = 0; k < 3; ++k) rate[at + k] = sum[k];
  }
}

/// x ← increment that does first x, then d.
template <class T>
void compose(const Compiled& m, T* x, const T* d) {
  for (const BodyData& b : m.bodies) {
    const JointInfo& info = joint_info(b.joint);
    T* xb = x + b.v;
    const T* db = d + b.v;
    const int plain = info.quaternion < 0 ? info.velocities : info.rotation;
    for (int k = 0; k < plain; ++k) xb[k] += db[k];
    if (info.quaternion >= 0) {
      T* t = xb + info.rotation;
      const T* s = db + info.rotation;
      const Vec3<T> u(t[0], t[1], t[2]), v(s[0], s[1], s[2]);
      const Vec3<T> sum = choose(
          u.squaredNorm() + v.squaredNorm() < T(1e-3),
          [&] {
            // log(exp u exp v) to third order (Baker, Campbell, Hausdorff): enough for a step of Newton's
            // method, as the positions follow from x itself.
            const Vec3<T> uv = u.cross(v);
            return Vec3<T>(u + v + T(0.5) * uv + T(1. / 12) * (u.cross(uv) - v.cross(uv)));
          },
          [&] {
            return quaternion_log<T>(quaternion_product<T>(quaternion_exp<T>(u), quaternion_exp<T>(v)));
          });
      for (int k = 0; k < 3; ++k) t[k] = sum[k];
    }
    for (int k = 0; k < b.modes; ++k) xb[info.velocities + k] += db[info.velocities + k];
  }
}

}  // namespace mimbre::relative
