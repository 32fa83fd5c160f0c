#pragma once
#include "dynamics/relative/workspace.h"
#include "forces/joint_spring.h"
#include "forces/load.h"
#include "forces/spring.h"
#include "forces/tyre.h"

/// Applied forces as wrenches on frames and on joint coordinates.
namespace mimbre::relative {

/// Clears the wrenches, then adds springs, tyres and loads; `generalised` (size velocities) is set to minus
/// the joint springs' forces. Writes also the states of springs, tyres and joint springs, whose tangents the
/// matrix uses.
template <class T>
void forces(const Compiled& m, Workspace<T>& w, double time, const T* q, const T* v, T* generalised) {
  for (auto& wrench : w.wrenches) {
    wrench.force.setZero();
    wrench.moment.setZero();
  }
  for (int k = 0; k < m.velocities; ++k) generalised[k] = T(0);
  for (std::size_t k = 0; k < m.springs.size(); ++k) {
    const SpringData& s = m.springs[k];
    const Motion<T>&A = w.frames[s.frame_a], &B = w.frames[s.frame_b];
    auto& state = w.springs[k];
    spring_state(s, Vec3<T>(B.position - A.position), Vec3<T>(B.velocity - A.velocity), time, state);
    w.wrenches[s.frame_a].force += state.tension * state.direction;
    w.wrenches[s.frame_b].force -= state.tension * state.direction;
  }
  for (std::size_t k = 0; k < m.tyres.size(); ++k) {
    const TyreData& t = m.tyres[k];
    auto& state = w.tyres[k];
    tyre_state(t, m.roads[t.road], Vec3<T>(w.frames[t.frame].position + w.origin.template cast<T>()), time,
               state);
    w.wrenches[t.frame].force[2] += state.force;
  }
  for (const LoadData& l : m.loads) {
    const LoadWrench<T> load = load_wrench<T>(l, w.frames[l.frame].rotation, time);
    w.wrenches[l.frame].force += load.force;
    w.wrenches[l.frame].moment += load.moment;
  }
  for (std::size_t k = 0; k < m.joint_springs.size(); ++k) {
    const JointSpringData& s = m.joint_springs[k];
    w.joint_springs[k] = joint_spring_state<T>(s, q[s.q], v[s.v]);
    generalised[s.v] += w.joint_springs[k].force;
  }
}

}  // namespace mimbre::relative
