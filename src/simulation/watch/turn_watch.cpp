#include "simulation/watch/turn_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "forces/measure_turning.h"
#include "math/elementary.h"
#include "simulation/describe/names.h"

namespace mimbre {
namespace {

/// By how much b has turned about other axes than that of its moment: so far laws by the rotation vector
/// depend on how turns about several axes are put together.
double turned_aside(const ElementState<const double>& s) {
  const Vec3d turned(s.x[3], s.x[4], s.x[5]), moment(s.force[3], s.force[4], s.force[5]);
  const double size = moment.norm();
  return size > 0 ? turned.cross(moment).norm() / size : 0;
}

}  // namespace

TurnWatch::TurnWatch(const Compiled& model) : model_(model) {
  for (int k = 0; k < static_cast<int>(model.elements.size()); ++k) {
    const ElementData& e = model.elements[k];
    const bool by_angle = e.measure == Measure::relative || (e.measure == Measure::axis && e.about);
    if (by_angle && !law_info(e.law).given && law_info(e.law).list != SpecList::sensors)
      watched_.push_back({k});
  }
}

void TurnWatch::start() {
  for (Watched& w : watched_) w = {w.element};
}

double TurnWatch::tilt_of(const ElementData& e, const relative::Workspace<double>& work) const {
  if (e.measure == Measure::axis) {
    const Vec3d in_a = work.frames[e.frame_a].rotation * e.direction,
                in_b = work.frames[e.frame_b].rotation * (e.rotation.transpose() * e.direction);
    return mimbre::atan2(in_a.cross(in_b).norm(), in_a.dot(in_b));
  }
  const ElementState<const double> s = element_state(e, work.elements.data());
  return std::max(turning::tilt(s.states + e.turns), turned_aside(s));
}

void TurnWatch::watch(const relative::Workspace<double>& work, double time) {
  for (Watched& w : watched_) {
    const double tilt = tilt_of(model_.elements[static_cast<std::size_t>(w.element)], work);
    if (tilt > w.tilt) {
      w.tilt = tilt;
      w.time = time;
    }
  }
}

void TurnWatch::transfer(StateTransfer& transfer) {
  for (Watched& w : watched_) transfer(w.tilt, w.time);
}

std::vector<std::string> TurnWatch::warnings() const {
  std::vector<std::string> all;
  for (const Watched& w : watched_)
    if (w.tilt > limit)
      all.push_back(fmt::format(
          "{} turned by {:.0f}° away from the axis of its moment (limit {:.0f}°, most at t = {:.6g} s): its "
          "law "
          "is by angles about single axes, which describe a turn about several only where it is small; use "
          "joints with springs for large turns about more than one axis",
          element_name(model_, model_.elements[static_cast<std::size_t>(w.element)]),
          w.tilt * 180 / std::numbers::pi, limit * 180 / std::numbers::pi, w.time));
  return all;
}

}  // namespace mimbre
