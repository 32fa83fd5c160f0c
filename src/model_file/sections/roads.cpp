#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <span>

#include "mimbre/tyre_file.h"
#include "model_file/sections/elements.h"
#include "model_file/sections/road_grids.h"
#include "model_file/sections/signals.h"
#include "model_file/sections/surface_files.h"
#include "model_file/text/builder.h"
#include "model_file/text/file_reader.h"
#include "spec/road_height.h"
#include "tyre_files/magic_numbers.h"

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
  if (!fields.has("x") && !fields.has("y")) value.error("has no place; for example x: [0, 10], y: [-2, 2]");
  if (const auto friction = fields.need("friction", "0.3"))
    patch.friction = friction->not_negative().value_or(1);
  road.patches.push_back(patch);
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
  std::optional<double> period;
  if (const auto repeat = fields.get("repeat")) {
    period = repeat->positive(along);
    if (period && *period < length * (1 - 1e-12))
      return repeat->error(fmt::format("{} is shorter than the points reach ({})", *period, length));
  }
  road.height = road_height(std::move(table->first), std::move(table->second), period);
}

void read_road(Builder& builder, const Part& part, const Value& value, spec::Road& road) {
  const std::vector<std::string> of_profile{"points", "repeat", "height"},
      of_grid{"origin", "spacing", "heights", "file", "iso8608"};
  std::vector<std::string> keys{"over", "friction", "patches"};
  for (const auto* more : {&of_profile, &of_grid}) keys.insert(keys.end(), more->begin(), more->end());
  const Fields fields(value, keys);
  if (!value.has_fields()) return;
  if (const auto over = fields.need("over", "distance"))
    road.over = static_cast<spec::Road::Over>(over->choice({"distance", "time", "grid"}).value_or(0));
  const bool grid = road.over == spec::Road::Over::grid;
  for (const std::string& key : grid ? of_profile : of_grid)
    if (const auto given = fields.get(key))
      given->error(grid ? "belongs to a road over distance or time; a grid has 'heights', 'file' or 'iso8608'"
                        : "belongs to a road `over: grid`");
  if (const auto friction = fields.get("friction")) road.friction = friction->not_negative().value_or(1);
  if (const auto patches = fields.get("patches"))
    for (const Value& patch : patches->list()) read_patch(patch, road);
  if (grid)
    read_road_heights(builder, fields, road);
  else
    read_profile(builder, part, fields, road);
}

/// What the models of tyres are called, their laws, and the keys that they need or may have.
struct TyreModel {
  std::string name;
  const LawInfo* law;
  std::vector<std::string> keys;
};
const std::vector<TyreModel>& tyre_models() {
  static const std::vector<TyreModel> models = [] {
    std::vector<TyreModel> all;
    for (const LawInfo* law : all_laws()) {
      if (law->list != SpecList::tyres) continue;
      TyreModel model{std::string(law->model), law, {}};
      if (law->by_file)
        model.keys = {"file"};
      else
        model.keys = {"stiffness", "radius"};
      if (law->rolling_size) model.keys.emplace_back("axis");
      for (const LawNumber& number : law->numbers) model.keys.emplace_back(number.key);
      all.push_back(std::move(model));
    }
    return all;
  }();
  return models;
}

/// The model that is chosen, and an error for each key that belongs to others.
const TyreModel& read_tyre_model(const Fields& fields) {
  const std::vector<TyreModel>& models = tyre_models();
  std::vector<std::string> names;
  for (const TyreModel& model : models) names.emplace_back(model.name);
  std::size_t chosen = 0;
  if (const auto given = fields.get("model"))
    if (const auto word = given->word()) {
      const auto found = std::find(names.begin(), names.end(), *word);
      if (found == names.end())
        given->error(fmt::format("there is no model '{}'; there are {}", *word, joined(names)));
      else
        chosen = static_cast<std::size_t>(found - names.begin());
    }
  const auto& own = models[chosen].keys;
  std::set<std::string> reported;
  for (const TyreModel& model : models)
    for (const std::string& key : model.keys)
      if (std::find(own.begin(), own.end(), key) == own.end() && reported.insert(key).second)
        if (const auto given = fields.get(key))
          given->error(fmt::format("belongs to 'model: {}'; one of 'model: {}' has {}", model.name,
                                   models[chosen].name, joined(own)));
  return models[chosen];
}

/// The formula's numbers of a property file, and how the carcass settles.
void read_property_file(Builder& builder, const LawInfo& law, const Fields& fields, const Value& value,
                        spec::Tyre& tyre) {
  const std::vector<double> behind = read_numbers(law, fields, value, false);
  const auto file = fields.need("file", "tyre.tir");
  const auto path = file ? file->word() : std::nullopt;
  if (!path || !has_folder(builder, *file)) return;
  const std::string found = path_of(builder, file->mark(), *path);
  builder.other_files.push_back(found);
  try {
    const TyreProperties read = builder.reader->tyre(found);
    if (!read.doubtful.empty())
      builder.warnings.push_back(
          {file->mark(), fmt::format("'{}': {}; the tyre is calculated without {}", *path,
                                     joined(read.doubtful), read.doubtful.size() > 1 ? "these" : "it")});
    tyre.numbers = read.numbers;
    tyre.radius = read.unloaded_radius;
    tyre.stiffness = read.numbers[forces::magic::vertical_stiffness];
  } catch (const InputError& e) {
    for (const Diagnostic& d : e.diagnostics()) file->error(to_string(d));
  }
  tyre.numbers.insert(tyre.numbers.end(), behind.begin(), behind.end());
}

void read_tyre(Builder& builder, const Part& part, const Value& value, spec::Tyre& tyre) {
  std::vector<std::string> keys{"on", "at", "road", "model"};
  for (const TyreModel& model : tyre_models())
    for (const std::string& key : model.keys)
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
  const Fields fields(value, keys);
  if (!value.has_fields()) return;
  const TyreModel& model = read_tyre_model(fields);
  const LawInfo& law = *model.law;
  tyre.law = law.name;
  if (const auto on = fields.need("on", "axle"))
    tyre.frame = attach(builder, part, *on, fields.get("at"), tyre.name + ".frame");
  if (const auto road = fields.need("road", "track"))
    if (const auto name = road->word()) tyre.road = builder.resolve(builder.road_names, part, *name, *road);
  if (law.by_file) {
    read_property_file(builder, law, fields, value, tyre);
  } else {
    if (const auto k = fields.need("stiffness", "4.6e5"))
      tyre.stiffness = k->positive(quantity::stiffness).value_or(1);
    if (const auto r = fields.need("radius", "0.36")) tyre.radius = r->positive(quantity::length).value_or(1);
    tyre.numbers = read_numbers(law, fields, value, false);
  }
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
