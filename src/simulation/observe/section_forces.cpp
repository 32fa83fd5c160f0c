#include "simulation/observe/section_forces.h"

namespace mimbre {

using Vector6d = Eigen::Matrix<double, 6, 1>;

Vector6d section_forces(const relative::RelativeSystem& system, const BarSections& sections, int body,
                        int section, const State& s) {
  const Compiled& m = system.model();
  const auto& w = system.workspace();
  const BodyData& b = m.bodies[body];
  const Motion<double>& motion = w.bodies[body];
  const Mat3d to_body = motion.rotation.transpose();
  const Vec3d omega = to_body * motion.omega, acceleration = to_body * motion.acceleration,
              alpha = to_body * motion.alpha;
  const auto influence = sections.influence.middleRows<6>(6 * section);
  Vector6d sum = Vector6d::Zero();
  Eigen::Index column = 0;
  const auto add = [&](double load) { sum += load * influence.col(column++); };
  for (int k = 0; k < 3; ++k) add(omega[k] * omega[k]);
  for (int k = 0; k < 3; ++k) add(omega[k] * omega[(k + 1) % 3]);
  for (int k = 0; k < 3; ++k) add(acceleration[k]);
  for (int k = 0; k < 3; ++k) add(alpha[k]);
  const int first = b.v + b.joint_velocities;
  for (int j = 0; j < b.modes; ++j) add(s.a[first + j]);
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < b.modes; ++j) add(omega[k] * s.v[first + j]);
  const Eigen::Index frames = column;
  const auto add_wrench = [&](int frame, const Vec3d& force, const Vec3d& moment) {
    const int place = m.spec().frames[static_cast<std::size_t>(m.frames[frame].spec)].flexible_frame;
    if (place < 0) return;  // on the clamped origin
    column = frames + 6 * place;
    const Vec3d f = to_body * force, n = to_body * moment;
    for (int k = 0; k < 3; ++k) add(f[k]);
    for (int k = 0; k < 3; ++k) add(n[k]);
  };
  for (int k = b.first_frame; k < b.last_frame; ++k) add_wrench(k, w.wrenches[k].force, w.wrenches[k].moment);
  // Its own joint's.
  const Wrench<double>& joint = w.transmitted[body];
  const Vec3d place =
      relative::output_motion(system, b.outboard_frame, s.q.data(), s.v.data(), s.a.data()).position;
  add_wrench(b.outboard_frame, joint.force, joint.moment - place.cross(joint.force));
  return sum;
}

}  // namespace mimbre
