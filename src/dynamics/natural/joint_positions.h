#pragma once
#include <cmath>
#include <numbers>

#include "dynamics/frame_turn.h"
#include "dynamics/natural/kinematics.h"
#include "joints/table.h"

namespace mimbre::natural {

/// Joint coordinates that belong to the unknowns in q; angles are taken within half a turn of those in q.
template <class T>
void joint_positions(const Compiled& m, const Layout& l, Workspace<T>& w, T* q) {
  for (int k = 0; k < l.unknown_variables; ++k) w.values[k] = Vec3<T>(q[3 * k], q[3 * k + 1], q[3 * k + 2]);
  for (std::size_t i = 0; i < l.bodies.size(); ++i)
    combine(l.bodies[i], w.values, static_cast<int>(l.bodies[i].variables.size()), w.poses[i]);
  const auto pose = [&](int frame, Vec3<T>& position, Mat3<T>& axes) {
    const FrameData& f = m.frames[frame];
    if (f.body < 0) {
      position = (f.position - l.origin).template cast<T>();
      axes = f.rotation.template cast<T>();
      return;
    }
    const Base<T>& base = w.poses[f.body];
    Vec3<T> place = f.position.template cast<T>();
    Mat3<T> rotation = f.rotation.template cast<T>();
    if (f.flexible >= 0) {
      T* y = w.row_modal.data();
      const int stride = m.flexible[f.flexible].stride, modes = m.bodies[f.body].modes;
      for (int k = 0; k < stride; ++k) y[k] = k < modes ? q[l.bodies[f.body].q + k] : T(0);
      extend(m.flexible[f.flexible], y);
      place += times(f.X, y);
      if (f.turns) rotation = turn_rotation<T>(f, y) * f.rotation.template cast<T>();
    }
    position = base.col(0) + base.template rightCols<3>() * place;
    axes = base.template rightCols<3>() * rotation;
  };
  for (const JointCoordinate& c : l.joint_coordinates) {
    using std::round;
    if (m.bodies[c.body].joint_positions == 0) continue;
    Vec3<T> ra, rb;
    Mat3<T> Aa, Ab;
    pose(c.frame_a, ra, Aa);
    pose(c.frame_b, rb, Ab);
    const spec::JointType type = m.bodies[c.body].joint;
    const JointInfo& info = joint_info(type);
    T fresh[7];
    joint_coordinates<T>(type, Aa.transpose() * Ab, Aa.transpose() * (rb - ra), fresh);
    T* x = q + c.q;
    if (info.quaternion >= 0) {
      // Of the two that mean the same, the one nearer to the last.
      T product = T(0);
      for (int k = info.quaternion; k < info.quaternion + 4; ++k) product += x[k] * fresh[k];
      for (int k = info.quaternion; k < info.quaternion + 4; ++k)
        x[k] = product < T(0) ? T(-fresh[k]) : fresh[k];
      for (int k = 0; k < info.quaternion; ++k) x[k] = fresh[k];
      continue;
    }
    for (int k = 0; k < info.positions; ++k) {
      const T turn(2 * std::numbers::pi);
      x[k] = is_angle(type, k) ? T(fresh[k] + turn * round((x[k] - fresh[k]) / turn)) : fresh[k];
    }
  }
}

}  // namespace mimbre::natural
