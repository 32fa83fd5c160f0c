#pragma once
#include "dynamics/motion.h"

namespace mimbre {

/// A small change of the motion of all points of a mechanism alike, as if it were one rigid body: what the
/// parts do relative to each other stays, so that loops stay closed. It is the motion carried along by a
/// frame that stands at the centre of mass turned by `turn` and moved by `move`, and that moves with `rate`
/// and `spin` but does not accelerate:
///   r' = c + move + Q (r − c),   ṙ' = ċ + rate + Q (ṙ − ċ) + spin × Q (r − c),
///   r̈' = c̈ + Q (r̈ − c̈) + 2 spin × Q (ṙ − ċ) + spin × (spin × Q (r − c))
struct RigidShift {
  Vec3d centre = Vec3d::Zero(), velocity = Vec3d::Zero(), acceleration = Vec3d::Zero();  ///< c, ċ, c̈
  Mat3d turn = Mat3d::Identity();                                                        ///< Q
  Vec3d move = Vec3d::Zero(), rate = Vec3d::Zero(), spin = Vec3d::Zero();

  /// Of a vector fixed in a body, with its rates.
  void vector(Vec3d& e, Vec3d& first, Vec3d& second) const {
    e = turn * e;
    const Vec3d carried = turn * first, swept = spin.cross(e);
    second = turn * second + spin.cross(2 * carried + swept);
    first = carried + swept;
  }
  void point(Vec3d& r, Vec3d& first, Vec3d& second) const {
    Vec3d e = r - centre, e1 = first - velocity, e2 = second - acceleration;
    vector(e, e1, e2);
    r = centre + move + e;
    first = velocity + rate + e1;
    second = acceleration + e2;
  }
  Motion<double> operator()(Motion<double> m) const {
    point(m.position, m.velocity, m.acceleration);
    m.rotation = turn * m.rotation;
    const Vec3d omega = turn * m.omega;
    m.alpha = turn * m.alpha + spin.cross(omega);
    m.omega = omega + spin;
    return m;
  }
};

}  // namespace mimbre
