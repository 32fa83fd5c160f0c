#include "compile/compile_parts.h"
#include "compile/paths.h"
#include "compile/signals/compile_signals.h"

namespace mimbre {

void compile_loops(Compiled& c, const Topology& topology) {
  const spec::Model& spec = c.spec();
  for (int k : topology.cut_joints) {
    const spec::Joint& j = spec.joints[k];
    LoopData loop;
    loop.joint_spec = k;
    loop.frame_a = c.frame_of_spec[j.frame_a];
    loop.frame_b = c.frame_of_spec[j.frame_b];
    loop.first_equation = c.equations;
    loop.count = joint_info(j.type).equations;
    const auto& closure = joint_info(j.type).closure;
    loop.closure.assign(closure.begin(), closure.begin() + loop.count);
    loop.path = make_path(c, loop.frame_a, loop.frame_b);
    loop.jacobian = add_jacobian(c, loop.path, loop.count);
    c.equations += loop.count;
    c.loops.push_back(std::move(loop));
  }
}

void compile_drives(Compiled& c) {
  const spec::Model& spec = c.spec();
  for (int b = 0; b < static_cast<int>(c.bodies.size()); ++b) {
    const BodyData& body = c.bodies[b];
    const auto& drives = spec.joints[body.joint_spec].drives;
    for (int k = 0; k < static_cast<int>(drives.size()); ++k) {
      const int coordinate = drives[k].coordinate;
      c.drives.push_back({body.joint_spec, b, body.q + coordinate, body.v + coordinate, c.equations++,
                          coordinate, drive_slot(c, body.joint_spec, k), 1.0});
    }
  }
}

}  // namespace mimbre
