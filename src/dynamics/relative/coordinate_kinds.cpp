#include "dynamics/coordinate_kinds.h"

#include <set>
#include <utility>

#include "dynamics/relative/evaluation.h"
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
    body.linear = !f.absolute() && !f.nonlinear_stiffness;
    out.bodies.push_back(std::move(body));
  }
  for (const DriveData& d : model_.drives) out.drives.push_back(d.equation);
  return out;
}

Eigen::VectorXd RelativeSystem::unloaded_residual(double t, const Eigen::VectorXd& q,
                                                  const Eigen::VectorXd& v, const Eigen::VectorXd& a) {
  evaluate_motion<double>(model_, work_, t, q.data(), v.data(), a.data());
  return residual_of_wrenches(q, v, a, -1, 0);
}

Eigen::VectorXd RelativeSystem::residual_of_wrenches(const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                                                     const Eigen::VectorXd& a, int frame, int direction) {
  for (auto& wrench : work_.wrenches) {
    wrench.force.setZero();
    wrench.moment.setZero();
  }
  if (frame >= 0) {
    auto& wrench = work_.wrenches[static_cast<std::size_t>(frame)];
    (direction < 3 ? wrench.force : wrench.moment)[direction % 3] = 1;
  }
  Eigen::VectorXd r = Eigen::VectorXd::Zero(model_.velocities);
  relative::residual<double>(model_, work_, q.data(), v.data(), a.data(), r.data());
  return r;
}

Eigen::MatrixXd RelativeSystem::element_loads(double t, const Eigen::VectorXd& q) {
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(model_.velocities);
  std::set<std::pair<int, int>> wrenches;  // frame, direction
  std::set<int> coordinates;
  for (const ElementData& e : model_.elements) {
    if (e.body >= 0) coordinates.insert(e.v);
    for (const int frame : {e.frame_a, e.frame_b})
      if (e.body < 0 && frame >= 0 && frame < std::ssize(work_.wrenches))
        for (int k = 0; k < (has_moment(e.measure) ? 6 : 3); ++k) wrenches.emplace(frame, k);
  }
  Eigen::MatrixXd out(model_.velocities, static_cast<Eigen::Index>(wrenches.size() + coordinates.size()));
  const Eigen::VectorXd unloaded = unloaded_residual(t, q, none, none);
  Eigen::Index column = 0;
  for (const auto& [frame, direction] : wrenches)
    out.col(column++) = unloaded - residual_of_wrenches(q, none, none, frame, direction);
  for (const int k : coordinates) out.col(column++) = Eigen::VectorXd::Unit(model_.velocities, k);
  return out;
}

}  // namespace mimbre::relative
