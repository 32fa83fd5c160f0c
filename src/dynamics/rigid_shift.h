#pragma once
#include "dynamics/motion.h"

namespace mimbre {

/// A small change of the motion of all points of a mechanism alike, as if it were one rigid body: what the
/// parts do relative to each other stays, so that loops stay closed. It is the motion carried along by a
/// frame that stands at the centre of mass turned by `turn` and moved by `move`, and that moves with `rate`
/// and `spin` but does not accelerate:
///   r' = c + move + Q (r − c),   ṙ' = ċ + rate + Q (ṙ − ċ) + spin × Q (r − c),
///   r̈' = c̈ + Q (r̈ − c̈) + 2 spin × Q (ṙ − ċ) + spin × (spin × Q (r − c))
template <class T>
struct RigidShiftOf {
  Vec3<T> centre = Vec3<T>::Zero(), velocity = Vec3<T>::Zero(), acceleration = Vec3<T>::Zero();  ///< c, ċ, c̈
  Mat3<T> turn = Mat3<T>::Identity();                                                            ///< Q
  Vec3<T> move = Vec3<T>::Zero(), rate = Vec3<T>::Zero(), spin = Vec3<T>::Zero();

  /// Of a vector fixed in a body, with its rates.
  void vector(Vec3<T>& e, Vec3<T>& first, Vec3<T>& second) const {
    e = turn * e;
    const Vec3<T> carried = turn * first, swept = spin.cross(e);
    second = turn * second + spin.cross(T(2) * carried + swept);
    first = carried + swept;
  }
  void point(Vec3<T>& r, Vec3<T>& first, Vec3<T>& second) const {
    Vec3<T> e = r - centre, e1 = first - velocity, e2 = second - acceleration;
    vector(e, e1, e2);
    r = centre + move + e;
    first = velocity + rate + e1;
    second = acceleration + e2;
  }
  Motion<T> operator()(Motion<T> m) const {
    point(m.position, m.velocity, m.acceleration);
    m.rotation = turn * m.rotation;
    const Vec3<T> omega = turn * m.omega;
    m.alpha = turn * m.alpha + spin.cross(omega);
    m.omega = omega + spin;
    return m;
  }
};
using RigidShift = RigidShiftOf<double>;

}  // namespace mimbre
