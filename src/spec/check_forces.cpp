#include "spec/checked_thing.h"
#include "spec/force_law.h"
#include "spec/nearest_place.h"

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
  if (at_one_place(place(spring.frame_a), place(spring.frame_b)))
    thing.error("has length 0 in the assembled position: its direction is not defined; move one end");
}

void check_friction(const Thing& thing, const spec::Road& road) {
  thing.not_negative("friction", road.friction);
  for (const spec::Road::Patch& patch : road.patches) {
    thing.not_negative("friction of a patch", patch.friction);
    for (int k = 0; k < 2; ++k)
      if (!(patch.low[k] < patch.high[k]))
        thing.error(fmt::format("a patch goes from {} to {} along {}; the first has to be the smaller one",
                                patch.low[k], patch.high[k], k == 0 ? "x" : "y"));
  }
}

/// What read_road_grid has seen to already, of a grid that users made.
void check_along_line(const Thing& thing, const RoadGrid& grid) {
  const std::size_t along = grid.along(), across = grid.across();
  if (along < 2 || across < 2)
    return thing.error(
        fmt::format("has a line of {} points and {} sections; at least 2 of both are needed", along, across));
  const auto of_line = [&](const char* what, std::size_t count) {
    if (count != along)
      thing.error(fmt::format("its line has {} points, but {} numbers of {}", along, count, what));
    return count == along;
  };
  if (grid.height.size() != along * across)
    return thing.error(fmt::format("has {} heights for {} × {} points", grid.height.size(), along, across));
  bool sound = of_line("y", grid.y.size()) & of_line("line_height", grid.line_height.size()) &
               of_line("bank", grid.bank.size());
  if (!grid.right.empty() || !grid.left.empty())
    sound &= of_line("right", grid.right.size()) & of_line("left", grid.left.size());
  if (!sound) return;
  const auto finite = [&](const char* what, const std::vector<double>& numbers) {
    return thing.finite(
        what, Eigen::Map<const Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size())));
  };
  sound = finite("x", grid.x) & finite("y", grid.y) & finite("line_height", grid.line_height) &
          finite("bank", grid.bank) & finite("v", grid.v) & finite("height", grid.height) &
          finite("right", grid.right) & finite("left", grid.left);
  if (!sound) return;
  for (std::size_t k = 1; k < across; ++k)
    if (!(grid.v[k] > grid.v[k - 1]))
      return thing.error(fmt::format("its v do not grow: {} comes after {}", grid.v[k], grid.v[k - 1]));
  double before_x = 0, before_y = 0;
  for (std::size_t i = 1; i < along; ++i) {
    const double dx = grid.x[i] - grid.x[i - 1], dy = grid.y[i] - grid.y[i - 1];
    if (!(dx * dx + dy * dy > 0))
      return thing.error(fmt::format("the points {} and {} of its line are one", i - 1, i));
    if (i > 1 && !(dx * before_x + dy * before_y > 0))
      return thing.error(fmt::format("its line turns by 90° or more at its point {}", i - 1));
    before_x = dx;
    before_y = dy;
  }
}

void check_grid(const Thing& thing, const spec::Road& road) {
  if (road.along_line.along() > 0) {
    if (road.heights.size() > 0) thing.error("has both 'heights' and a grid along a line");
    return check_along_line(thing, road.along_line);
  }
  if (road.heights.rows() < 2 || road.heights.cols() < 2)
    thing.error(fmt::format("has {} × {} heights; a grid has at least 2 × 2", road.heights.rows(),
                            road.heights.cols()));
  thing.finite("heights", road.heights);
  thing.finite("origin", road.origin);
  thing.positive("spacing along x", road.spacing[0]);
  thing.positive("spacing along y", road.spacing[1]);
}

/// Of the numbers by which a law describes a tyre.
void check_numbers(const Thing& thing, const spec::Tyre& tyre, const LawInfo& law) {
  if (law.by_file) {
    std::vector<std::string> faults;
    law.check_file(tyre.numbers, faults);
    for (const std::string& fault : faults) thing.error(fault);
    return;
  }
  if (tyre.numbers.size() != law.numbers.size())
    return thing.error(fmt::format("law '{}' has {} numbers, {} are given", tyre.law, law.numbers.size(),
                                   tyre.numbers.size()));
  for (std::size_t k = 0; k < law.numbers.size(); ++k)
    if (!law.numbers[k].allows(tyre.numbers[k]))
      thing.error(fmt::format("{} {}", law.numbers[k].key, wrong_number(law.numbers[k], tyre.numbers[k])));
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
    thing.enumerator("over", road.over, 3);
    check_friction(thing, road);
    if (road.over == spec::Road::Over::grid) {
      check_grid(thing, road);
      continue;
    }
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
    const int law = find_law(tyre.law);
    if (law < 0 || law_info(law).list != SpecList::tyres) {
      std::vector<std::string> known;
      for (const LawInfo* info : all_laws())
        if (info->list == SpecList::tyres) known.push_back(fmt::format("'{}'", info->name));
      thing.error(
          fmt::format("there is no law '{}' of tyres; there are {}", tyre.law, fmt::join(known, ", ")));
      continue;
    }
    if (law_info(law).rolling_size && thing.finite("axis", tyre.axis) && !(tyre.axis.norm() > 0))
      thing.error("axis has no length; give a vector such as (0, 1, 0)");
    check_numbers(thing, tyre, law_info(law));
  }
}

}  // namespace mimbre::checks
