#include "dynamics/relative/shift.h"

#include "dynamics/relative/kinematics.h"

namespace mimbre::relative {
namespace {

/// The joint's velocity coordinates when its frame on the body moves so.
Eigen::Matrix<double, 6, 1> joint_velocities(const BodyData& b, const Motion<double>& ground,
                                             const Motion<double>& frame, const Vec3d& velocity,
                                             const Vec3d& omega) {
  Eigen::Matrix<double, 6, 1> v;
  if (!b.reversed)
    v << ground.rotation.transpose() * velocity, frame.rotation.transpose() * omega;
  else  // the body carries frame a, from which the ground's frame b moves
    v << -(frame.rotation.transpose() * (velocity + omega.cross(ground.position - frame.position))),
        -(ground.rotation.transpose() * omega);
  return v;
}

/// Of the frame on the body.
Motion<double> frame_of(const BodyData& b, Workspace<double>& w, const State& s) {
  Motion<double> frame;
  joint_step<double>(b, w.frames[b.inboard_frame], s.q.data() + b.q, s.v.data() + b.v, s.a.data() + b.v,
                     frame, &w.joint_angular[b.v], &w.joint_linear[b.v]);
  return frame;
}

}  // namespace

void shift_root(const Compiled& m, Workspace<double>& w, int root, const RigidShift& shift, State& s) {
  const BodyData& b = m.bodies[root];
  const Motion<double>& ground = w.frames[b.inboard_frame];
  double *q = s.q.data() + b.q, *a = s.a.data() + b.v;
  const Motion<double> frame = frame_of(b, w, s), to = shift(frame);
  const Eigen::Matrix<double, 6, 1> before = s.a.segment<6>(b.v);
  s.v.segment<6>(b.v) = joint_velocities(b, ground, to, to.velocity, to.omega);
  Eigen::Map<Vec3d> place(q), acceleration(a), turning(a + 3);
  Quat<double> turn(q[3], q[4], q[5], q[6]);
  const Mat3d& G = ground.rotation;
  if (!b.reversed) {
    place += G.transpose() * (to.position - frame.position);
    acceleration += G.transpose() * (to.acceleration - frame.acceleration);
    turning = to.rotation.transpose() * to.alpha;
    turn = quaternion_product<double>(quaternion_of(Mat3d(G.transpose() * shift.turn * G)), turn);
  } else {
    const Mat3d At = to.rotation.transpose();
    const Vec3d r = ground.position - to.position, u = -(to.velocity + to.omega.cross(r));
    place = At * r;
    acceleration = At * (ground.acceleration - to.acceleration - to.alpha.cross(r) -
                         to.omega.cross(to.omega.cross(r) + 2 * u));
    turning = -(G.transpose() * to.alpha);
    const Mat3d inverse = frame.rotation.transpose() * shift.turn.transpose() * frame.rotation;
    turn = quaternion_product<double>(quaternion_of(inverse), turn);
  }
  turn.normalize();
  for (int k = 0; k < 4; ++k) q[3 + k] = turn[k];
  s.algorithmic.segment<6>(b.v) += s.a.segment<6>(b.v) - before;
}

void add_rigid_motion(const Compiled& m, Workspace<double>& w, int root, double times, const Vec3d& velocity,
                      const Vec3d& spin, State& s) {
  const BodyData& b = m.bodies[root];
  const Motion<double> frame = frame_of(b, w, s);
  s.v.segment<6>(b.v) += times * joint_velocities(b, w.frames[b.inboard_frame], frame,
                                                  velocity + spin.cross(frame.position), spin);
}

}  // namespace mimbre::relative
