#pragma once
#include <cmath>

#include "compile/compiled.h"
#include "dynamics/relative/momentum.h"
#include "dynamics/rigid_shift.h"
#include "joints/joint_kind.h"
#include "math/elementary.h"

/// What bodies that fly freely keep, and by which shift they keep it, for any scalar: FreeFlight makes it,
/// and generated code.
namespace mimbre::flight {

/// Within this angle of steady rotation about a principal axis energy is stationary: round-off in it would
/// show more than the error of a step.
constexpr double steady = 1e-4;

/// Energy of rotation ½ Lᵀ J⁻¹ L, of which a group that is turned by θ at constant momentum gains θ · gain.
template <class T>
struct Rotation {
  T energy = 0;
  Vec3<T> gain = Vec3<T>::Zero();
};
template <class T>
Rotation<T> rotation_of(const Mat3<T>& inertia, const Vec3<T>& angular) {
  const Vec3<T> spin = relative::mean_spin<T>(inertia, angular);
  return {T(0.5) * angular.dot(spin), spin.cross(angular)};
}

/// The turn that brings the energy of rotation back to `energy`.
template <class T>
Mat3<T> restoring_turn(const Mat3<T>& inertia, const Vec3<T>& angular, const T& energy) {
  Mat3<T> turn = Mat3<T>::Identity();
  for (int round = 0; round < 2; ++round) {
    const Rotation<T> r = rotation_of<T>(turn * inertia * turn.transpose(), angular);
    const T slope = r.gain.squaredNorm();
    const Vec3<T> theta = (energy - r.energy) / slope * r.gain;
    // A larger turn would not be the error of a step.
    turn = choose(
        slope > T(steady * steady) * r.energy * r.energy && theta.squaredNorm() < T(0.01),
        [&] { return Mat3<T>(rotation_exp<T>(theta) * turn); }, [&] { return turn; });
  }
  return turn;
}

/// A group at the start of a step.
template <class T>
struct Start {
  Vec3<T> centre = Vec3<T>::Zero();  ///< relative to the common point
  Vec3<T> velocity = Vec3<T>::Zero(), angular = Vec3<T>::Zero();
  T rotation = 0;  ///< energy of it, J
  T gain = 0;      ///< of it over the step, by the change of shape, J
};
template <class T>
Start<T> start_of(const relative::MomentumOf<T>& p) {
  return {p.centre, p.velocity(), p.angular, rotation_of<T>(p.inertia, p.angular).energy, T(0)};
}

/// By which a group with momentum `p` comes to where the laws hold, h after its start; `moved`: where the
/// common point of the start is from that of now.
template <class T>
RigidShiftOf<T> restoring_shift(const Start<T>& start, const relative::MomentumOf<T>& p,
                                const Vec3<T>& gravity, const Vec3<T>& moved, double h) {
  const Vec3<T> gained = T(h) * gravity;
  RigidShiftOf<T> shift;
  shift.centre = p.centre;
  shift.velocity = p.velocity();
  shift.rate = start.velocity + gained - shift.velocity;
  shift.move = start.centre - p.centre + moved + T(h) * (start.velocity + T(0.5) * gained);
  shift.turn = restoring_turn<T>(p.inertia, start.angular, T(start.rotation + start.gain));
  shift.spin = relative::mean_spin<T>(shift.turn * p.inertia * shift.turn.transpose(),
                                      start.angular - shift.turn * p.angular);
  return shift;
}

/// Constant rates of the coordinates by which a step of h came from `from` to `to`; the roots', which no
/// shape depends on, are their velocities v.
template <class T>
void set_rates(const Compiled& m, const T* from, const T* to, const T* v, double h, T* rates) {
  using std::sqrt, mimbre::atan2;
  for (int k = 0; k < m.velocities; ++k) rates[k] = v[k];
  for (const BodyData& b : m.bodies) {
    const JointInfo& info = joint_info(b.joint);
    const T *p = from + b.q, *r = to + b.q;
    T* out = rates + b.v;
    if (b.parent >= 0) {
      const int plain = info.quaternion < 0 ? info.velocities : info.rotation;
      for (int k = 0; k < plain; ++k) out[k] = (r[k] - p[k]) / T(h);
      if (info.quaternion >= 0) {
        // The conjugate of p times r.
        const T *pq = p + info.quaternion, *rq = r + info.quaternion;
        const Vec3<T> pv(pq[1], pq[2], pq[3]), rv(rq[1], rq[2], rq[3]);
        const Vec3<T> axis = pq[0] * rv - rq[0] * pv - pv.cross(rv);
        const T sine = sqrt(axis.squaredNorm()), cosine = pq[0] * rq[0] + pv.dot(rv);
        const T angle = choose(
            sine > T(0), [&] { return T(T(2) * atan2(sine, cosine) / sine); }, [] { return T(2); });
        Eigen::Map<Vec3<T>>(out + info.rotation) = angle / T(h) * axis;
      }
    }
    for (int k = 0; k < b.modes; ++k)
      out[info.velocities + k] = (r[info.positions + k] - p[info.positions + k]) / T(h);
  }
}

}  // namespace mimbre::flight
