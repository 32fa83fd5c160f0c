#pragma once
#include "dynamics/relative/kinematics.h"
#include "dynamics/relative/shift.h"

namespace mimbre::relative {
namespace shift_parts {

template <class T>
using Velocities = Eigen::Matrix<T, 6, 1>;

/// The joint's velocity coordinates when its frame on the body moves so.
template <class T>
Velocities<T> joint_velocities(const BodyData& b, const Motion<T>& ground, const Motion<T>& frame,
                               const Vec3<T>& velocity, const Vec3<T>& omega) {
  Velocities<T> v;
  if (!b.reversed)
    v << ground.rotation.transpose() * velocity, frame.rotation.transpose() * omega;
  else  // the body carries frame a, from which the ground's frame b moves
    v << -(frame.rotation.transpose() * (velocity + omega.cross(ground.position - frame.position))),
        -(ground.rotation.transpose() * omega);
  return v;
}

/// Of the frame on the body.
template <class T>
Motion<T> frame_of(const BodyData& b, Workspace<T>& w, const T* q, const T* v, const T* a) {
  Motion<T> frame;
  joint_step<T>(b, w.frames[b.inboard_frame], q + b.q, v + b.v, a + b.v, frame, &w.joint_angular[b.v],
                &w.joint_linear[b.v]);
  return frame;
}

}  // namespace shift_parts

template <class T>
void shift_root(const Compiled& m, Workspace<T>& w, int root, const RigidShiftOf<T>& shift,
                const MovedState<T>& s) {
  using std::sqrt;
  const BodyData& b = m.bodies[root];
  const Motion<T>& ground = w.frames[b.inboard_frame];
  T *q = s.q + b.q, *a = s.a + b.v;
  const Motion<T> frame = shift_parts::frame_of<T>(b, w, s.q, s.v, s.a), to = shift(frame);
  using Six = Eigen::Map<shift_parts::Velocities<T>>;
  const shift_parts::Velocities<T> before = Six(a);
  Six(s.v + b.v) = shift_parts::joint_velocities<T>(b, ground, to, to.velocity, to.omega);
  Eigen::Map<Vec3<T>> place(q), acceleration(a), turning(a + 3);
  Quat<T> turn(q[3], q[4], q[5], q[6]);
  const Mat3<T>& G = ground.rotation;
  if (!b.reversed) {
    place += G.transpose() * (to.position - frame.position);
    acceleration += G.transpose() * (to.acceleration - frame.acceleration);
    turning = to.rotation.transpose() * to.alpha;
    turn = quaternion_product<T>(quaternion_of(Mat3<T>(G.transpose() * shift.turn * G)), turn);
  } else {
    const Mat3<T> At = to.rotation.transpose();
    const Vec3<T> r = ground.position - to.position, u = -(to.velocity + to.omega.cross(r));
    place = At * r;
    acceleration = At * (ground.acceleration - to.acceleration - to.alpha.cross(r) -
                         to.omega.cross(to.omega.cross(r) + T(2) * u));
    turning = -(G.transpose() * to.alpha);
    const Mat3<T> inverse = frame.rotation.transpose() * shift.turn.transpose() * frame.rotation;
    turn = quaternion_product<T>(quaternion_of(inverse), turn);
  }
  turn /= T(sqrt(turn.squaredNorm()));
  for (int k = 0; k < 4; ++k) q[3 + k] = turn[k];
  Six(s.algorithmic + b.v) += Six(a) - before;
}

}  // namespace mimbre::relative
