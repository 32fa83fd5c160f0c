#include <fmt/format.h>

#include "model_file/builder.h"
#include "model_file/elements.h"
#include "model_file/heights.h"
#include "model_file/signals.h"

/// Roads, and tyres on them.
namespace mimbre::model_file {
namespace {

/// x: [0, 10], y: [-2, 2], friction: 0.3.
void read_patch(const Value& value, spec::Road& road) {
  const Fields fields(value, {"x", "y", "friction"});
  if (!value.has_fields()) return;
  constexpr double everywhere = 1e300;
  spec::Road::Patch patch;
  patch.low.setConstant(-everywhere);
  patch.high.setConstant(everywhere);
  const auto interval = [&](const char* key, Eigen::Index k) {
    const auto given = fields.get(key);
    const auto numbers = given ? given->numbers(2, 2, quantity::length) : std::nullopt;
    if (!numbers) return;
    patch.low[k] = (*numbers)[0];
    patch.high[k] = (*numbers)[1];
    if (!(patch.low[k] < patch.high[k])) given->error("goes from a smaller to a larger number");
  };
  interval("x", 0);
  interval("y", 1);
  if (!fields.has("x") && !fields.has("y"))
    value.error("does not say where it is; for example x: [0, 10], y: [-2, 2]");
  if (const auto friction = fields.need("friction", "0.3"))
    patch.friction = friction->not_negative().value_or(1);
  road.patches.push_back(patch);
}

void read_grid(const Fields& fields, spec::Road& road) {
  const auto pair = [&](const char* key, const char* example, Eigen::Vector2d& to) {
    if (const auto given = fields.need(key, example))
      if (const auto numbers = given->numbers(2, 2, quantity::length)) to = {(*numbers)[0], (*numbers)[1]};
  };
  pair("origin", "[0, -5]", road.origin);
  pair("spacing", "[0.5, 0.5]", road.spacing);
  const auto heights = fields.need("heights", "[[0, 0], [0, 0.1]]");
  if (auto read = heights ? read_heights(*heights) : std::nullopt) road.heights = std::move(*read);
}

/// Over distance, or over time.
void read_profile(Builder& builder, const Part& part, const Fields& fields, spec::Road& road) {
  if (const auto height = fields.get("height")) {
    if (fields.has("points")) return height->error("give 'points' or 'height', not both");
    if (road.over != spec::Road::Over::time)
      return height->error("is of time and signals: it belongs to a road `over: time`");
    road.signal = anonymous_signal(builder, part, *height, road.name + ".height", quantity::length);
    return;
  }
  const auto points = fields.need("points", "[[0, 0], [10, 0]]");
  const Quantity& along = road.over == spec::Road::Over::time ? quantity::time : quantity::length;
  auto table = points ? read_points(*points, true, along, quantity::length) : std::nullopt;
  if (!table) return;
  road.draw_from = table->first.front();
  road.draw_to = table->first.back();
  const double length = road.draw_to - road.draw_from;
  road.height =
      Function::table(std::move(table->first), std::move(table->second), Function::Interpolation::linear);
  if (const auto repeat = fields.get("repeat")) {
    const auto period = repeat->positive(along);
    if (!period) return;
    if (*period < length * (1 - 1e-12))
      return repeat->error(fmt::format("{} is shorter than the points reach ({})", *period, length));
    road.height = road.height.repeated(road.draw_from, *period);
  }
}

void read_road(Builder& builder, const Part& part, const Value& value, spec::Road& road) {
  const std::vector<std::string> of_profile{"points", "repeat", "height"},
      of_grid{"origin", "spacing", "heights"};
  std::vector<std::string> keys{"over", "friction", "patches"};
  for (const auto* more : {&of_profile, &of_grid}) keys.insert(keys.end(), more->begin(), more->end());
  const Fields fields(value, keys);
  if (!value.has_fields()) return;
  if (const auto over = fields.need("over", "distance"))
    road.over = static_cast<spec::Road::Over>(over->choice({"distance", "time", "grid"}).value_or(0));
  const bool grid = road.over == spec::Road::Over::grid;
  for (const std::string& key : grid ? of_profile : of_grid)
    if (const auto given = fields.get(key))
      given->error(grid ? "belongs to a road over distance or time; a grid has 'heights'"
                        : "belongs to a road `over: grid`");
  if (const auto friction = fields.get("friction")) road.friction = friction->not_negative().value_or(1);
  if (const auto patches = fields.get("patches"))
    for (const Value& patch : patches->list()) read_patch(patch, road);
  if (grid)
    read_grid(fields, road);
  else
    read_profile(builder, part, fields, road);
}

/// What the models of tyres are called, and their laws.
constexpr std::array<std::pair<const char*, Law>, 2> models{
    {{"vertical", Law::tyre}, {"brush", Law::brush_tyre}}};

void read_tyre(Builder& builder, const Part& part, const Value& value, spec::Tyre& tyre) {
  std::vector<std::string> keys{"on", "at", "road", "model", "stiffness", "radius", "axis"};
  for (const auto& model : models)
    for (const LawNumber& number : law_info(static_cast<int>(model.second)).numbers)
      keys.emplace_back(number.key);
  const Fields fields(value, keys);
  if (!value.has_fields()) return;
  Law law = Law::tyre;
  if (const auto model = fields.get("model"))
    law = models[static_cast<std::size_t>(model->choice({models[0].first, models[1].first}).value_or(0))]
              .second;
  const LawInfo& info = law_info(static_cast<int>(law));
  tyre.law = info.name;
  if (const auto on = fields.need("on", "axle"))
    tyre.frame = attach(builder, part, *on, fields.get("at"), tyre.name + ".frame");
  if (const auto road = fields.need("road", "track"))
    if (const auto name = road->word()) tyre.road = builder.resolve(builder.road_names, part, *name, *road);
  if (const auto k = fields.need("stiffness", "4.6e5"))
    tyre.stiffness = k->positive(quantity::stiffness).value_or(1);
  if (const auto r = fields.need("radius", "0.36")) tyre.radius = r->positive(quantity::length).value_or(1);
  if (law == Law::tyre) {
    for (std::size_t k = 6; k < keys.size(); ++k)
      if (const auto given = fields.get(keys[k]))
        given->error("belongs to a tyre that rolls; a vertical one has 'stiffness' and 'radius'");
    return;
  }
  tyre.numbers = read_numbers(info, fields, value, false);
  const auto axis = fields.get("axis");
  const auto direction = axis ? axis->direction() : std::nullopt;
  if (tyre.frame >= 0)
    tyre.axis = builder.global_pose(tyre.frame).rotation.transpose() *
                part.place.pseudo_vector(direction.value_or(Eigen::Vector3d::UnitY()));
}

}  // namespace

void read_roads(Builder& builder, Part& part) {
  read_each(builder, part, "roads", builder.road_names, builder.model.roads, read_road);
}

void read_tyres(Builder& builder, Part& part) {
  read_each(builder, part, "tyres", builder.tyre_names, builder.model.tyres, read_tyre);
}

}  // namespace mimbre::model_file
