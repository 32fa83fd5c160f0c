#include "model/checked_thing.h"

/// Springs, loads, roads and tyres.
namespace mimbre::checks {
namespace {

int body_of(const spec::Model& model, int frame) {
  return model.frames[static_cast<std::size_t>(frame)].body;
}

void check_spring(const spec::Model& model, const Thing& thing, const spec::Spring& spring) {
  if (spring.elastic.is_zero() && spring.damping.is_zero() && spring.general.formula.is_zero())
    thing.error("says no force; give 'elastic', 'damping' or a law of both");
  const bool a = thing.index("frame_a", spring.frame_a, model.frames.size(), "frames");
  const bool b = thing.index("frame_b", spring.frame_b, model.frames.size(), "frames");
  if (!a || !b || !sound_frame(model, spring.frame_a) || !sound_frame(model, spring.frame_b)) return;
  if (body_of(model, spring.frame_a) == spec::ground && body_of(model, spring.frame_b) == spec::ground)
    thing.error("both ends are on the ground");
  const auto place = [&](int frame) {
    return assembled_place(model, model.frames[static_cast<std::size_t>(frame)]);
  };
  const double length = (place(spring.frame_b) - place(spring.frame_a)).norm();
  if (length == 0)
    thing.error("has length 0 in the assembled position: its direction is not defined; move one end");
}

}  // namespace

void check_springs(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.springs.size(); ++k)
    check_spring(model, Thing(errors, "spring", model.springs[k].name, model.springs[k].mark, k),
                 model.springs[k]);
}

void check_loads(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.loads.size(); ++k) {
    const spec::Load& load = model.loads[k];
    const Thing thing(errors, "load", load.name, load.mark, k);
    thing.finite("force", load.force);
    thing.finite("moment", load.moment);
    if (load.signal >= 0)
      thing.index("signal", load.signal, model.signals.size(), "signals");
    else if (load.scale.is_zero())
      thing.error("has no scale; Function::constant(1) keeps the force as it is");
    else
      thing.finite("scale at t = 0", load.scale.value(0));
    if (thing.index("frame", load.frame, model.frames.size(), "frames") && sound_frame(model, load.frame) &&
        body_of(model, load.frame) == spec::ground)
      thing.error("a load on the ground moves nothing; give it a frame on a body");
  }
}

void check_roads(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.roads.size(); ++k) {
    const spec::Road& road = model.roads[k];
    const Thing thing(errors, "road", road.name, road.mark, k);
    thing.enumerator("over", road.over, 2);
    if (road.signal >= 0) {
      thing.index("signal", road.signal, model.signals.size(), "signals");
      if (road.over == spec::Road::Over::distance)
        thing.error("a road over distance has no signal; give it a height");
    } else if (road.height.is_zero())
      thing.error("has no height; Function::constant(0) is level ground");
    const bool from = thing.finite("draw_from", road.draw_from), to = thing.finite("draw_to", road.draw_to);
    if (from && to && road.draw_from > road.draw_to)
      thing.error(fmt::format("draw_from {} is beyond draw_to {}", road.draw_from, road.draw_to));
  }
}

void check_tyres(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.tyres.size(); ++k) {
    const spec::Tyre& tyre = model.tyres[k];
    const Thing thing(errors, "tyre", tyre.name, tyre.mark, k);
    thing.index("frame", tyre.frame, model.frames.size(), "frames");
    thing.index("road", tyre.road, model.roads.size(), "roads");
    thing.positive("stiffness", tyre.stiffness);
    thing.positive("radius", tyre.radius);
  }
}

}  // namespace mimbre::checks
