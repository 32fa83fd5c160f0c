#include "simulation/watch/spin_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dynamics/relative/momentum.h"
#include "joints/joint_kind.h"
#include "math/elementary.h"

namespace mimbre {
namespace {

/// The step is to have some room below the limit, since there the motion is another one.
constexpr double room = 0.8;

/// h² |ω̇| of a body without moments, rad.
double change_of_rotation(Mechanism& mechanism, int body, const std::vector<int>& carried, double length) {
  const BodyData& b = mechanism.model.bodies[body];
  const State& s = mechanism.view();
  relative::Workspace<double>& w = mechanism.observer.workspace();
  const relative::Momentum p =
      relative::momentum<double>(mechanism.model, w, carried, s.q.data(), s.v.data());
  const Motion<double>& motion = w.bodies[body];
  Mat3d inertia = p.inertia;
  if (!joint_info(b.joint).free()) {  // about its point
    const FrameData& frame = mechanism.model.frames[b.outboard_frame];
    const Vec3d arm = p.centre - motion.position - motion.rotation * frame.position;
    inertia += p.mass * (arm.squaredNorm() * Mat3d::Identity() - arm * arm.transpose());
  }
  const Vec3d moment = motion.omega.cross(inertia * motion.omega);
  return length * length * relative::mean_spin<double>(inertia, moment).norm();
}

/// Two digits, rounded down.
double rounded_down(double x) {
  const double unit = mimbre::pow(10, std::floor(mimbre::log10(x)) - 1);
  return std::floor(x / unit) * unit;
}

}  // namespace

SpinWatch::SpinWatch(const Compiled& model) {
  const int count = static_cast<int>(model.bodies.size());
  for (int i = 0; i < count; ++i) {
    if (joint_info(model.bodies[i].joint).quaternion < 0) continue;
    Watched watched;
    watched.body = i;
    std::vector<char> carried(model.bodies.size(), 0);
    for (int k = i; k < count; ++k) {
      const int parent = model.bodies[k].parent;
      carried[k] = k == i || (parent >= 0 && carried[parent]);
      if (carried[k]) watched.carried.push_back(k);
    }
    bodies_.push_back(std::move(watched));
  }
}

void SpinWatch::start() {
  for (Watched& w : bodies_) {
    w.first = -1;
    w.excess = 1;
    w.turn = w.step = w.time = w.enough = 0;
    w.natural = false;
  }
}

void SpinWatch::watch(Mechanism& mechanism, double length) {
  const State& s = mechanism.view();
  for (Watched& w : bodies_) {
    const BodyData& b = mechanism.model.bodies[w.body];
    const double* const rate = s.v.data() + b.v + joint_info(b.joint).rotation;
    const double turn = length * std::sqrt(rate[0] * rate[0] + rate[1] * rate[1] + rate[2] * rate[2]);
    if (!(turn > spin_limit::natural_floating)) continue;
    double excess = 0, enough = 0;
    if (mechanism.natural) {
      const bool floating = joint_info(b.joint).free();
      excess = turn / (floating ? spin_limit::natural_floating : spin_limit::natural_spherical);
      enough = length / excess;
    } else {
      excess = change_of_rotation(mechanism, w.body, w.carried, length) / spin_limit::change;
      enough = length / std::sqrt(std::max(excess, 1.0));
    }
    if (!(excess > 1)) continue;
    if (w.first < 0) w.first = mechanism.state.time;
    if (!(excess > w.excess)) continue;
    w.excess = excess;
    w.turn = turn;
    w.step = length;
    w.time = mechanism.state.time;
    w.enough = enough;
    w.natural = mechanism.natural != nullptr;
  }
}

void SpinWatch::transfer(StateTransfer& transfer) {
  for (Watched& w : bodies_) transfer(w.first, w.excess, w.turn, w.step, w.time, w.enough, w.natural);
}

std::vector<std::string> SpinWatch::warnings(const Compiled& model) const {
  std::vector<std::string> all;
  for (const Watched& w : bodies_)
    if (w.first >= 0)
      all.push_back(fmt::format(
          "body '{}' turns too far in a step, from t = {:.6g} s on: by {:.2g} rad at t = {:.6g} s{} of "
          "{:.4g} s "
          "miss more than 0.5 % of it; take a step of {:.2g} s",
          model.spec().bodies[model.bodies[w.body].spec].name, w.first, w.turn, w.time,
          w.natural ? ", and natural coordinates in steps" : ", about an axis that turns, too, so that steps",
          w.step, rounded_down(room * w.enough)));
  return all;
}

}  // namespace mimbre
