#include "simulation/watch/road_watch.h"

#include <fmt/format.h>

#include "forces/element.h"
#include "simulation/describe/names.h"
#include "simulation/watch/tyre_gap.h"

namespace mimbre {

RoadWatch::RoadWatch(const Compiled& m) : model_(m) {
  for (int k = m.first_tyre; k < m.first_load; ++k)
    if (m.roads[m.elements[k].road].along_line()) watched_.push_back({k});
}

void RoadWatch::start() {
  for (Watched& w : watched_) w = {w.element};
}

void RoadWatch::watch(const relative::Workspace<double>& work, double time) {
  for (Watched& w : watched_) {
    if (w.from >= 0) continue;
    const ElementData& e = model_.elements[w.element];
    const ElementState<const double> s = element_state(e, work.elements.data());
    if (tyre_gap(model_, e, s) > 0) continue;
    const Vec3d place = work.frames[e.frame_b].position + work.origin;
    if (roads::is_on_road(model_.roads[e.road].own, place[0], place[1])) continue;
    w.from = time;
    w.at = {place[0], place[1]};
  }
}

void RoadWatch::transfer(StateTransfer& transfer) {
  for (Watched& w : watched_) transfer(w.from, w.at[0], w.at[1]);
}

std::vector<std::string> RoadWatch::warnings() const {
  std::vector<std::string> all;
  for (const Watched& w : watched_)
    if (w.from >= 0) {
      const ElementData& e = model_.elements[w.element];
      all.push_back(fmt::format(
          "{}: it leaves the road '{}' at t = {:.6g} s, over x = {:.6g} m, y = {:.6g} m; the file has no "
          "heights there, and the road goes on level as at its border",
          element_name(model_, e), model_.spec().roads[static_cast<std::size_t>(e.road)].name, w.from,
          w.at[0], w.at[1]));
    }
  return all;
}

}  // namespace mimbre
