#include "spec/check/checked_item.h"
#include "spec/force_law.h"
#include "spec/nearest_place.h"

/// Springs, loads, roads and tyres.
namespace mimbre::checks {
namespace {

int body_of(const spec::Model& model, int frame) {
  return model.frames[static_cast<std::size_t>(frame)].body;
}

void check_spring(const spec::Model& model, const CheckedItem& item, const spec::Spring& spring) {
  if (spring.elastic.is_zero() && spring.damping.is_zero() && spring.general.formula.is_zero())
    item.error("specifies no force; give 'elastic', 'damping' or a law of both");
  const bool a = item.index("frame_a", spring.frame_a, model.frames.size(), "frames");
  const bool b = item.index("frame_b", spring.frame_b, model.frames.size(), "frames");
  if (!a || !b || !sound_frame(model, spring.frame_a) || !sound_frame(model, spring.frame_b)) return;
  if (body_of(model, spring.frame_a) == spec::ground && body_of(model, spring.frame_b) == spec::ground)
    item.error("both ends are on the ground");
  const auto place = [&](int frame) {
    return assembled_place(model, model.frames[static_cast<std::size_t>(frame)]);
  };
  if (at_one_place(place(spring.frame_a), place(spring.frame_b)))
    item.error("has length 0 in the assembled position: its direction is not defined; move one end");
}

void check_friction(const CheckedItem& item, const spec::Road& road) {
  item.not_negative("friction", road.friction);
  for (const spec::Road::Patch& patch : road.patches) {
    item.not_negative("friction of a patch", patch.friction);
    for (int k = 0; k < 2; ++k)
      if (!(patch.low[k] < patch.high[k]))
        item.error(fmt::format("a patch goes from {} to {} along {}; the first has to be the smaller one",
                               patch.low[k], patch.high[k], k == 0 ? "x" : "y"));
  }
}

/// What read_road_grid has seen to already, of a grid that users made.
void check_along_line(const CheckedItem& item, const RoadGrid& grid) {
  const std::size_t along = grid.along(), across = grid.across();
  if (along < 2 || across < 2)
    return item.error(
        fmt::format("has a line of {} points and {} sections; at least 2 of both are needed", along, across));
  const auto of_line = [&](const char* what, std::size_t count) {
    if (count != along)
      item.error(fmt::format("its line has {} points, but {} numbers of {}", along, count, what));
    return count == along;
  };
  if (grid.height.size() != along * across)
    return item.error(fmt::format("has {} heights for {} × {} points", grid.height.size(), along, across));
  bool sound = of_line("y", grid.y.size()) & of_line("line_height", grid.line_height.size()) &
               of_line("bank", grid.bank.size());
  if (!grid.right.empty() || !grid.left.empty())
    sound &= of_line("right", grid.right.size()) & of_line("left", grid.left.size());
  if (!sound) return;
  const auto finite = [&](const char* what, const std::vector<double>& numbers) {
    return item.finite(
        what, Eigen::Map<const Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size())));
  };
  sound = finite("x", grid.x) & finite("y", grid.y) & finite("line_height", grid.line_height) &
          finite("bank", grid.bank) & finite("v", grid.v) & finite("height", grid.height) &
          finite("right", grid.right) & finite("left", grid.left);
  if (!sound) return;
  for (std::size_t k = 1; k < across; ++k)
    if (!(grid.v[k] > grid.v[k - 1]))
      return item.error(fmt::format("its v do not grow: {} comes after {}", grid.v[k], grid.v[k - 1]));
  double before_x = 0, before_y = 0;
  for (std::size_t i = 1; i < along; ++i) {
    const double dx = grid.x[i] - grid.x[i - 1], dy = grid.y[i] - grid.y[i - 1];
    if (!(dx * dx + dy * dy > 0))
      return item.error(fmt::format("the points {} and {} of its line are one", i - 1, i));
    if (i > 1 && !(dx * before_x + dy * before_y > 0))
      return item.error(fmt::format("its line turns by 90° or more at its point {}", i - 1));
    before_x = dx;
    before_y = dy;
  }
}

void check_grid(const CheckedItem& item, const spec::Road& road) {
  if (road.along_line.along() > 0) {
    if (road.heights.size() > 0) item.error("has both 'heights' and a grid along a line");
    return check_along_line(item, road.along_line);
  }
  if (road.heights.rows() < 2 || road.heights.cols() < 2)
    item.error(fmt::format("has {} × {} heights; a grid has at least 2 × 2", road.heights.rows(),
                           road.heights.cols()));
  item.finite("heights", road.heights);
  item.finite("origin", road.origin);
  item.positive("spacing along x", road.spacing[0]);
  item.positive("spacing along y", road.spacing[1]);
}

/// Of the numbers by which a law describes a tyre.
void check_numbers(const CheckedItem& item, const spec::Tyre& tyre, const LawInfo& law) {
  if (law.by_file) {
    std::vector<std::string> faults;
    law.check_file(tyre.numbers, faults);
    for (const std::string& fault : faults) item.error(fault);
    return;
  }
  if (tyre.numbers.size() != law.numbers.size())
    return item.error(fmt::format("law '{}' has {} numbers, {} are given", tyre.law, law.numbers.size(),
                                  tyre.numbers.size()));
  for (std::size_t k = 0; k < law.numbers.size(); ++k)
    if (!law.numbers[k].allows(tyre.numbers[k]))
      item.error(fmt::format("{} {}", law.numbers[k].key, wrong_number(law.numbers[k], tyre.numbers[k])));
  if (law.fault)
    if (const std::string_view fault = law.fault(tyre.numbers); !fault.empty())
      item.error(std::string(fault));
}

}  // namespace

void check_springs(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.springs.size(); ++k)
    check_spring(model, CheckedItem(errors, "spring", model.springs[k].name, model.springs[k].mark, k),
                 model.springs[k]);
}

void check_loads(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.loads.size(); ++k) {
    const spec::Load& load = model.loads[k];
    const CheckedItem item(errors, "load", load.name, load.mark, k);
    item.finite("force", load.force);
    item.finite("moment", load.moment);
    if (load.signal >= 0)
      item.index("signal", load.signal, model.signals.size(), "signals");
    else if (load.scale.is_zero())
      item.error("has no scale; Function::constant(1) keeps the force as it is");
    else
      item.finite("scale at t = 0", load.scale.value(0));
    if (item.index("frame", load.frame, model.frames.size(), "frames") && sound_frame(model, load.frame) &&
        body_of(model, load.frame) == spec::ground)
      item.error("a load on the ground moves nothing; give it a frame on a body");
  }
}

void check_roads(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.roads.size(); ++k) {
    const spec::Road& road = model.roads[k];
    const CheckedItem item(errors, "road", road.name, road.mark, k);
    item.enumerator("over", road.over, 3);
    check_friction(item, road);
    if (road.over == spec::Road::Over::grid) {
      check_grid(item, road);
      continue;
    }
    if (road.signal >= 0) {
      item.index("signal", road.signal, model.signals.size(), "signals");
      if (road.over == spec::Road::Over::distance)
        item.error("a road over distance has no signal; give it a height");
    } else if (road.height.is_zero())
      item.error("has no height; Function::constant(0) is level ground");
    const bool from = item.finite("draw_from", road.draw_from), to = item.finite("draw_to", road.draw_to);
    if (from && to && road.draw_from > road.draw_to)
      item.error(fmt::format("draw_from {} is beyond draw_to {}", road.draw_from, road.draw_to));
  }
}

void check_tyres(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.tyres.size(); ++k) {
    const spec::Tyre& tyre = model.tyres[k];
    const CheckedItem item(errors, "tyre", tyre.name, tyre.mark, k);
    item.index("frame", tyre.frame, model.frames.size(), "frames");
    item.index("road", tyre.road, model.roads.size(), "roads");
    item.positive("stiffness", tyre.stiffness);
    item.positive("radius", tyre.radius);
    const int law = find_law(tyre.law);
    if (law < 0 || law_info(law).list != SpecList::tyres) {
      std::vector<std::string> known;
      for (const LawInfo* info : all_laws())
        if (info->list == SpecList::tyres) known.push_back(fmt::format("'{}'", info->name));
      item.error(
          fmt::format("there is no law '{}' of tyres; there are {}", tyre.law, fmt::join(known, ", ")));
      continue;
    }
    if (law_info(law).rolling_size && item.finite("axis", tyre.axis) && !(tyre.axis.norm() > 0))
      item.error("axis has no length; give a vector such as (0, 1, 0)");
    check_numbers(item, tyre, law_info(law));
  }
}

}  // namespace mimbre::checks
