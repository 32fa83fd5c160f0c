#include "simulation/start/held_elsewhere.h"

#include <algorithm>
#include <utility>

#include "mimbre/reduced_body.h"

namespace mimbre {
namespace {

/// Of the largest motion of a frame by the modes: less is none.
constexpr double unmoved = 1e-9;

bool has_loads_of_inertia(const spec::Body& body) {
  if (!body.flexible || body.flexible->modes == 0 || !body.flexible->geometric) return false;
  const std::vector<int>& loads = body.flexible->geometric->loads;
  return !loads.empty() && loads.front() < GeometricStiffness::boundary;
}

/// Of each frame of the body whether its modes move it.
std::vector<bool> moved_frames(const ReducedBody& body) {
  double shift = 0, turn = 0;
  for (const BodyFrame& f : body.frames) {
    shift = std::max(shift, f.X.norm());
    turn = std::max(turn, f.X_theta.norm());
  }
  std::vector<bool> moved;
  for (const BodyFrame& f : body.frames)
    moved.push_back(f.X.norm() > unmoved * shift || f.X_theta.norm() > unmoved * turn);
  return moved;
}

/// Bodies by number, the ground behind them, that joints connect with what is marked, the body left out.
void spread(const spec::Model& model, int body, std::vector<bool>& reached) {
  const auto ground = static_cast<int>(model.bodies.size());
  const auto place = [&](int frame) {
    const int at = model.frames[static_cast<std::size_t>(frame)].body;
    return at < 0 ? ground : at;
  };
  for (bool more = true; more;) {
    more = false;
    for (const spec::Joint& joint : model.joints) {
      const int a = place(joint.frame_a), b = place(joint.frame_b);
      if (a == body || b == body) continue;
      if (reached[static_cast<std::size_t>(a)] == reached[static_cast<std::size_t>(b)]) continue;
      reached[static_cast<std::size_t>(a)] = reached[static_cast<std::size_t>(b)] = more = true;
    }
  }
}

}  // namespace

std::vector<int> bodies_held_elsewhere(const spec::Model& model) {
  std::vector<int> out;
  for (std::size_t k = 0; k < model.bodies.size(); ++k) {
    if (!has_loads_of_inertia(model.bodies[k])) continue;
    const std::vector<bool> moved = moved_frames(*model.bodies[k].flexible);
    if (std::find(moved.begin(), moved.end(), false) == moved.end()) continue;
    const auto ground = model.bodies.size();
    std::vector<bool> grounded(ground + 1, false);
    grounded[ground] = true;
    spread(model, static_cast<int>(k), grounded);
    bool there = false, elsewhere = false;
    for (const spec::Joint& joint : model.joints)
      for (const auto& [own, other] :
           {std::pair{joint.frame_a, joint.frame_b}, std::pair{joint.frame_b, joint.frame_a}}) {
        const spec::Frame& frame = model.frames[static_cast<std::size_t>(own)];
        if (frame.body != static_cast<int>(k)) continue;
        const int beyond = model.frames[static_cast<std::size_t>(other)].body;
        if (!grounded[beyond < 0 ? ground : static_cast<std::size_t>(beyond)]) continue;
        const bool moves = frame.node >= 0 || (frame.flexible_frame >= 0 &&
                                               moved[static_cast<std::size_t>(frame.flexible_frame)]);
        (moves ? elsewhere : there) = true;
      }
    if (elsewhere && !there) out.push_back(static_cast<int>(k));
  }
  return out;
}

}  // namespace mimbre
