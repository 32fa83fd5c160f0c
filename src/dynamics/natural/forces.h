#pragma once
#include "dynamics/natural/joint_rates.h"
#include "forces/joint_spring.h"
#include "forces/load.h"
#include "forces/spring.h"
#include "forces/tyre.h"

/// Applied forces on the bodies' base vectors and amplitudes, with the sign of the residual (minus the
/// force).
namespace mimbre::natural {

/// After kinematics; writes also the states of springs, tyres and joint springs, whose tangents the matrix
/// uses.
template <class T>
void forces(const Compiled& m, const Layout& l, Workspace<T>& w, double time, const T* q) {
  for (std::size_t k = 0; k < m.springs.size(); ++k) {
    const SpringData& s = m.springs[k];
    const FrameMotion<T>&A = w.frames[s.frame_a], &B = w.frames[s.frame_b];
    auto& state = w.springs[k];
    spring_state(s, Vec3<T>(B.position - A.position), Vec3<T>(B.velocity - A.velocity), time, state);
    const Vec3<T> pull = state.tension * state.direction;
    act_on_point<T>(m.frames[s.frame_a], A, -pull, collector(m, l, w, l.springs[k].body_a));
    act_on_point<T>(m.frames[s.frame_b], B, pull, collector(m, l, w, l.springs[k].body_b));
  }
  for (std::size_t k = 0; k < m.tyres.size(); ++k) {
    const TyreData& t = m.tyres[k];
    auto& state = w.tyres[k];
    const FrameMotion<T>& wheel = w.frames[t.frame];
    tyre_state(t, m.roads[t.road], Vec3<T>(wheel.position + l.origin.template cast<T>()), time, state);
    act_on_point<T>(m.frames[t.frame], wheel, Vec3<T>(T(0), T(0), -state.force),
                    collector(m, l, w, l.tyres[k].body_b));
  }
  for (const LoadData& load : m.loads) {
    const FrameMotion<T>& frame = w.frames[load.frame];
    const LoadWrench<T> wrench = load_wrench<T>(load, frame.axes, time);
    const Covector<T> on = collector(m, l, w, m.frames[load.frame].body);
    act_on_point<T>(m.frames[load.frame], frame, -wrench.force, on);
    act_by_moment<T>(m.frames[load.frame], frame, -wrench.moment, on);
  }
  for (std::size_t k = 0; k < m.joint_springs.size(); ++k) {
    const JointSpringData& s = m.joint_springs[k];
    const JointCoordinate& c = l.joint_coordinates[s.body];
    const BodyData& body = m.bodies[s.body];
    const FrameMotion<T>&A = w.frames[c.frame_a], &B = w.frames[c.frame_b];
    JointRates<T> rates;
    joint_rates<T>(body.joint, body.joint_velocities, A, B, q + c.q, rates);
    w.joint_springs[k] = joint_spring_state<T>(s, q[c.q + s.local], rates.v[s.local]);
    act_on_coordinate<T>(m, c, A, B, q + c.q, s.local, w.joint_springs[k].force,
                         collector(m, l, w, l.joint_springs[k].body_a),
                         collector(m, l, w, l.joint_springs[k].body_b));
  }
}

}  // namespace mimbre::natural
