#include "dynamics/relative/shift_impl.h"

namespace mimbre::relative {

template void shift_root<double>(const Compiled&, Workspace<double>&, int, const RigidShift&,
                                 const MovedState<double>&);

void add_rigid_motion(const Compiled& m, Workspace<double>& w, int root, double times, const Vec3d& velocity,
                      const Vec3d& spin, State& s) {
  const BodyData& b = m.bodies[root];
  const Motion<double> frame = shift_parts::frame_of<double>(b, w, s.q.data(), s.v.data(), s.a.data());
  s.v.segment<6>(b.v) +=
      times * shift_parts::joint_velocities<double>(b, w.frames[b.inboard_frame], frame,
                                                    velocity + spin.cross(frame.position), spin);
}

}  // namespace mimbre::relative
