#include "dynamics/coordinate_kinds.h"

#include "dynamics/relative/system.h"
#include "joints/joint_kind.h"

namespace mimbre::relative {

CoordinateKinds RelativeSystem::coordinate_kinds() const {
  using Kind = CoordinateKinds::Kind;
  CoordinateKinds out;
  out.kind.assign(static_cast<std::size_t>(model_.velocities), Kind::plain);
  out.position.assign(static_cast<std::size_t>(model_.velocities), 0);
  const auto set = [&](int coordinate, Kind kind, int position) {
    out.kind[static_cast<std::size_t>(coordinate)] = kind;
    out.position[static_cast<std::size_t>(coordinate)] = position;
  };
  for (const BodyData& b : model_.bodies) {
    const JointInfo& info = joint_info(b.joint);
    const int plain = info.quaternion < 0 ? info.velocities : info.rotation;
    for (int k = 0; k < plain; ++k) set(b.v + k, Kind::plain, b.q + k);
    for (int k = plain; k < info.velocities; ++k) set(b.v + k, Kind::rotation, b.q + info.quaternion);
    for (int k = 0; k < b.modes; ++k)
      set(b.v + info.velocities + k, Kind::amplitude, b.q + info.positions + k);
    if (b.modes == 0) continue;
    const FlexibleData& f = model_.flexible[static_cast<std::size_t>(b.flexible)];
    CoordinateKinds::Body body;
    body.first = b.v + info.velocities;
    body.stiffness.resize(b.modes, b.modes);
    for (int r = 0; r < b.modes; ++r)
      for (int c = 0; c < b.modes; ++c) body.stiffness(r, c) = f.stiffness(r, c);
    body.linear = f.ancf.empty() && !f.nonlinear_stiffness;
    out.bodies.push_back(std::move(body));
  }
  return out;
}

}  // namespace mimbre::relative
