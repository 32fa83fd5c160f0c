#include <fmt/format.h>

#include <Eigen/Geometry>

#include "model_file/builder.h"

/// Springs, loads, roads and tyres.
namespace mimbre::model_file {
namespace {

/// Calls `one(name, entry, value)` for every named thing of a section and counts it in `names`.
template <class Read>
void for_each(Builder& builder, Part& part, const std::string& key, Names& names, std::size_t& count,
              Read&& one) {
  const auto section = part.section(key);
  if (!section) return;
  if (!section->is_map()) return section->error("names with their descriptions are needed");
  for (const auto& entry : section->tree().entries) {
    const std::string name = part.full_name(entry.key);
    if (!builder.claim(names, part, name, entry.mark, static_cast<int>(count))) continue;
    one(name, entry.mark, Value(part.reading, *entry.value, fmt::format("{} '{}'", names.kind, name)));
    ++count;
  }
}

void read_ends(Builder& builder, const Part& part, const Fields& fields, spec::Spring& spring) {
  const auto between = fields.need("between", "[arm, chassis]");
  if (!between) return;
  const auto pair = between->list();
  if (pair.size() != 2) {
    if (between->is_list()) between->error("two bodies or frames are needed, for example [arm, chassis]");
    return;
  }
  std::vector<std::optional<Value>> places(2);
  if (const auto at = fields.get("at")) {
    const auto list = at->list();
    if (list.size() != 2) {
      if (at->is_list()) at->error("two places are needed: [[x, y, z], [x, y, z]]");
      return;
    }
    for (std::size_t k = 0; k < 2; ++k)
      if (!list[k].is_null()) places[k] = list[k];
  }
  spring.frame_a = attach(builder, part, pair[0], places[0], spring.name + ".a");
  spring.frame_b = attach(builder, part, pair[1], places[1], spring.name + ".b");
  if (spring.frame_a < 0 || spring.frame_b < 0) return;
  const auto body = [&](int frame) { return builder.model.frames[static_cast<std::size_t>(frame)].body; };
  const auto a = builder.global_pose(spring.frame_a), b = builder.global_pose(spring.frame_b);
  if (!((a.position - b.position).norm() > 1e-9))
    fields.error(fmt::format("has length zero: both ends are at {}; it needs a direction to pull in",
                             to_text(a.position)));
  else if (body(spring.frame_a) == spec::ground && body(spring.frame_b) == spec::ground)
    between->error("both ends are on the ground");
  else if (const int one = body(spring.frame_a);
           one == body(spring.frame_b) && !builder.bodies[static_cast<std::size_t>(one)].flexible)
    builder.warnings.push_back(
        {between->mark(),
         fmt::format("spring '{}' has both ends on the rigid body '{}', which does "
                     "not move against itself: it does nothing",
                     spring.name, builder.model.bodies[static_cast<std::size_t>(one)].name)});
}

void read_spring(Builder& builder, const Part& part, const Value& value, spec::Spring& spring) {
  const Fields fields(value, {"between", "at", "elastic", "damping", "force"});
  if (!value.has_fields()) return;
  read_ends(builder, part, fields, spring);
  const auto elastic = fields.get("elastic"), damping = fields.get("damping"), force = fields.get("force");
  if (!elastic && !damping && !force)
    value.error("says no force; for example elastic: {stiffness: 1000, zero: 0.5}");
  if (elastic) spring.elastic = read_elastic_law(*elastic, units_of_length.elastic()).value_or(Function{});
  if (damping) spring.damping = read_damping_law(*damping, units_of_length.damper()).value_or(Function{});
  if (!force) return;
  // Not as a word: '?:' chooses between forces here.
  const auto text = force->text();
  if (!text) return;
  try {
    spring.general = Function3::expression(
        substitute_parameters(*text, *part.reading.scope, variables_of(LawOf::all), quantity::force),
        {"l", "v", "t"});
  } catch (const ExpressionError& e) {
    force->error(e.what());
  } catch (const InputError& e) {
    force->error(e.diagnostics().front().message);
  }
}

void read_load(Builder& builder, const Part& part, const Value& value, spec::Load& load) {
  const Fields fields(value, {"on", "at", "force", "moment", "scale", "follower"});
  if (!value.has_fields()) return;
  const auto on = fields.need("on", "arm.tip");
  if (on) load.frame = attach(builder, part, *on, fields.get("at"), load.name + ".frame");
  const auto force = fields.get("force"), moment = fields.get("moment");
  if (!force && !moment) value.error("has no force and no moment; for example force: [0, 0, -10]");
  if (force) load.force = part.place.vector(force->triple(quantity::force).value_or(Eigen::Vector3d::Zero()));
  if (moment)
    load.moment =
        part.place.pseudo_vector(moment->triple(quantity::moment).value_or(Eigen::Vector3d::Zero()));
  load.scale = Function::constant(1);
  if (const auto scale = fields.get("scale"))
    load.scale = read_law(*scale, LawOf::time, {quantity::time, quantity::number, quantity::number})
                     .value_or(Function{});
  if (const auto follower = fields.get("follower")) load.follower = follower->flag().value_or(false);
  if (load.frame < 0) return;
  if (builder.model.frames[static_cast<std::size_t>(load.frame)].body == spec::ground)
    on->error("a load on the ground moves nothing; name a body");
  if (load.follower) {
    // Given in global axes of the assembled position; from there on it turns with the frame.
    const Eigen::Matrix3d axes = builder.global_pose(load.frame).rotation;
    load.force = (axes.transpose() * load.force).eval();
    load.moment = (axes.transpose() * load.moment).eval();
  }
}

void read_road(const Value& value, spec::Road& road) {
  const Fields fields(value, {"over", "points", "repeat"});
  if (!value.has_fields()) return;
  if (const auto over = fields.need("over", "distance"))
    road.over = static_cast<spec::Road::Over>(over->choice({"distance", "time"}).value_or(0));
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

void read_tyre(Builder& builder, const Part& part, const Value& value, spec::Tyre& tyre) {
  const Fields fields(value, {"on", "at", "road", "stiffness", "radius"});
  if (!value.has_fields()) return;
  if (const auto on = fields.need("on", "axle"))
    tyre.frame = attach(builder, part, *on, fields.get("at"), tyre.name + ".frame");
  if (const auto road = fields.need("road", "track"))
    if (const auto name = road->word()) tyre.road = builder.resolve(builder.road_names, part, *name, *road);
  if (const auto k = fields.need("stiffness", "4.6e5"))
    tyre.stiffness = k->positive(quantity::stiffness).value_or(1);
  if (const auto r = fields.need("radius", "0.36")) tyre.radius = r->positive(quantity::length).value_or(1);
}

template <class Thing>
Thing named(const std::string& name, const Mark& mark) {
  Thing thing;
  thing.name = name;
  thing.mark = mark;
  return thing;
}

}  // namespace

void read_springs(Builder& builder, Part& part) {
  std::size_t count = builder.model.springs.size();
  for_each(builder, part, "springs", builder.spring_names, count,
           [&](const auto& name, const Mark& mark, const Value& v) {
             auto spring = named<spec::Spring>(name, mark);
             read_spring(builder, part, v, spring);
             builder.model.springs.push_back(std::move(spring));
           });
}

void read_loads(Builder& builder, Part& part) {
  std::size_t count = builder.model.loads.size();
  for_each(builder, part, "loads", builder.load_names, count,
           [&](const auto& name, const Mark& mark, const Value& v) {
             auto load = named<spec::Load>(name, mark);
             read_load(builder, part, v, load);
             builder.model.loads.push_back(std::move(load));
           });
}

void read_roads(Builder& builder, Part& part) {
  std::size_t count = builder.model.roads.size();
  for_each(builder, part, "roads", builder.road_names, count,
           [&](const auto& name, const Mark& mark, const Value& v) {
             auto road = named<spec::Road>(name, mark);
             read_road(v, road);
             builder.model.roads.push_back(std::move(road));
           });
}

void read_tyres(Builder& builder, Part& part) {
  std::size_t count = builder.model.tyres.size();
  for_each(builder, part, "tyres", builder.tyre_names, count,
           [&](const auto& name, const Mark& mark, const Value& v) {
             auto tyre = named<spec::Tyre>(name, mark);
             read_tyre(builder, part, v, tyre);
             builder.model.tyres.push_back(std::move(tyre));
           });
}

}  // namespace mimbre::model_file
