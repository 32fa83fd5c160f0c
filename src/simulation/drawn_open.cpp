#include "simulation/drawn_open.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "joints/table.h"

namespace mimbre {
namespace {

constexpr double noticeable = 1e-3;  ///< of the mechanism's size; rad
constexpr std::size_t named = 5;     ///< joints in the message

/// All joint coordinates zero: as the model was drawn.
Eigen::VectorXd drawn(const Compiled& m) {
  Eigen::VectorXd q = Eigen::VectorXd::Zero(m.positions);
  for (const BodyData& b : m.bodies)
    if (const int at = joint_info(b.joint).quaternion; at >= 0) q[b.q + at] = 1;
  return q;
}

}  // namespace

std::string drawn_open(relative::RelativeSystem& system, const State& s) {
  const Compiled& m = system.model();
  if (m.loops.empty()) return {};
  const Eigen::VectorXd q = drawn(m), rest = Eigen::VectorXd::Zero(m.velocities);
  const auto& frames = system.workspace().frames;
  const auto evaluate = [&](const Eigen::VectorXd& positions) {
    system.kinematics(s.time, positions.data(), rest.data(), rest.data());
  };
  const auto places = [&] {
    std::vector<Vec3d> out;
    for (int k = 0; k < m.dynamic_frames; ++k) out.push_back(frames[k].position);
    return out;
  };
  evaluate(q);
  const std::vector<Vec3d> before = places();
  Vec3d low = before.front(), high = low;
  for (const Vec3d& p : before) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const double extent = (high - low).norm();
  std::vector<std::string> joints;
  double gap = 0, turn = 0;
  for (const LoopData& l : m.loops) {
    double distance = 0, angle = 0;
    for (int r = 0; r < l.count; ++r) {
      const double phi = std::abs(system.phi()[l.first_equation + r]);
      double& largest = l.closure[r].kind == LoopClosure::Kind::distance ? distance : angle;
      largest = std::max(largest, phi);
    }
    if (distance <= noticeable * extent && angle <= noticeable) continue;
    joints.push_back(fmt::format("'{}'", m.spec().joints[l.joint_spec].name));
    gap = std::max(gap, distance);
    turn = std::max(turn, angle);
  }
  if (joints.empty()) return {};
  evaluate(s.q);
  const std::vector<Vec3d> after = places();
  double farthest = 0;
  int body = m.frames.front().body;
  for (int k = 0; k < m.dynamic_frames; ++k)
    if (const double way = (after[k] - before[k]).norm(); way > farthest)
      farthest = way, body = m.frames[k].body;
  const std::size_t count = joints.size();
  joints.resize(std::min(count, named));
  std::string text =
      fmt::format("{} drawn open, at joint{} {}{} by up to {}: closing {} moved ",
                  count == 1 ? "a loop is" : fmt::format("{} loops are", count), count == 1 ? "" : "s",
                  fmt::join(joints, ", "), count > named ? ", …" : "",
                  gap > noticeable * extent ? fmt::format("{:.3g} m", gap) : fmt::format("{:.3g} rad", turn),
                  count == 1 ? "it" : "them");
  if (farthest > 0 && body >= 0)
    text +=
        fmt::format("joints of body '{}' by {:.3g} m", m.spec().bodies[m.bodies[body].spec].name, farthest);
  else
    text += "bodies by angles only";
  return text + "; where that was not meant, check the points and axes of the loop's joints";
}

}  // namespace mimbre
