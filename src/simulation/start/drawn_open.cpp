#include "simulation/start/drawn_open.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "joints/joint_kind.h"
#include "simulation/describe/names.h"

namespace mimbre {
namespace {

constexpr double noticeable = 1e-3;  ///< of the mechanism's size; rad
constexpr std::size_t named = 5;     ///< places in the message

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
  if (m.loops.empty() && m.constraints.empty()) return {};
  // Bodies that were drawn apart are meant to move.
  const std::vector<spec::Joint>& joints_of_spec = m.spec().joints;
  if (std::any_of(joints_of_spec.begin(), joints_of_spec.end(), [](const auto& j) { return j.apart; }))
    return {};
  const Eigen::VectorXd q = drawn(m), rest = Eigen::VectorXd::Zero(m.velocities);
  const auto& frames = system.workspace().frames;
  const auto evaluate = [&](const Eigen::VectorXd& positions) {
    system.kinematics(s.time, positions.data(), rest.data(), rest.data());
  };
  const auto positions_of_frames = [&] {
    std::vector<Vec3d> out;
    for (int k = 0; k < m.dynamic_frames; ++k) out.push_back(frames[k].position);
    return out;
  };
  const std::vector<double> unturned(m.states.begin(), m.states.end());
  system.enter(s.u.data(), unturned.data(), 0);
  evaluate(q);
  const std::vector<Vec3d> before = positions_of_frames();
  Vec3d low = before.front(), high = low;
  for (const Vec3d& p : before) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const double extent = (high - low).norm();
  std::vector<std::string> places;
  double gap = 0, turn = 0;
  const auto look = [&](const EquationRows& rows, const auto& is_length) {
    double distance = 0, angle = 0;
    for (int r = 0; r < rows.count; ++r) {
      double& largest = is_length(r) ? distance : angle;
      largest = std::max(largest, std::abs(system.phi()[rows.first_equation + r]));
    }
    if (distance <= noticeable * extent && angle <= noticeable) return;
    places.push_back(equation_name(m, nullptr, rows.first_equation));
    gap = std::max(gap, distance);
    turn = std::max(turn, angle);
  };
  for (const LoopData& l : m.loops)
    look(l, [&](int r) { return l.closure[r].kind == LoopClosure::Kind::distance; });
  // Couplings take joints from where they are drawn to where their initial values are.
  for (const ConstraintData& c : m.constraints)
    if (!c.of_coordinates) look(c, [&](int r) { return c.is_length(r); });
  system.enter(s.u.data(), s.z.data(), 0);
  if (places.empty()) return {};
  evaluate(s.q);
  const std::vector<Vec3d> after = positions_of_frames();
  double farthest = 0;
  int body = m.frames.front().body;
  for (int k = 0; k < m.dynamic_frames; ++k)
    if (const double way = (after[k] - before[k]).norm(); way > farthest)
      farthest = way, body = m.frames[k].body;
  const std::size_t count = places.size();
  places.resize(std::min(count, named));
  std::string text =
      fmt::format("{} drawn open, at {}{} by up to {}: closing {} moved ",
                  count == 1 ? "a loop is" : fmt::format("{} loops are", count), fmt::join(places, ", "),
                  count > named ? ", …" : "",
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
