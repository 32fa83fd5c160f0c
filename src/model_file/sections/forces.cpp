#include <fmt/format.h>

#include <Eigen/Geometry>

#include "model_file/sections/elements.h"
#include "model_file/sections/signals.h"
#include "model_file/text/builder.h"

/// Springs and loads.
namespace mimbre::model_file {
namespace {

void read_spring_ends(Builder& builder, const Part& part, const Fields& fields, spec::Spring& spring) {
  std::tie(spring.frame_a, spring.frame_b) = read_ends(builder, part, fields, spring.name, false);
  if (spring.frame_a < 0 || spring.frame_b < 0) return;
  const Value between = *fields.get("between");
  const auto body = [&](int frame) { return builder.model.frames[static_cast<std::size_t>(frame)].body; };
  if (const int one = body(spring.frame_a);
      one >= 0 && one == body(spring.frame_b) && !builder.bodies[static_cast<std::size_t>(one)].flexible)
    builder.warnings.push_back(
        {between.mark(), fmt::format("spring '{}' has both ends on the rigid body '{}', which does "
                                     "not move against itself: it does nothing",
                                     spring.name, builder.model.bodies[static_cast<std::size_t>(one)].name)});
}

void read_spring(Builder& builder, const Part& part, const Value& value, spec::Spring& spring) {
  const Fields fields(value, {"between", "at", "elastic", "damping", "force"});
  if (!value.has_fields()) return;
  read_spring_ends(builder, part, fields, spring);
  const auto elastic = fields.get("elastic"), damping = fields.get("damping"), force = fields.get("force");
  if (!elastic && !damping && !force)
    value.error("specifies no force; for example elastic: {stiffness: 1000, zero: 0.5}");
  std::vector<FormulaTerm> terms;
  if (elastic && !add_term_with_signals(builder, part, *elastic, LawOf::coordinate, "l", terms))
    spring.elastic = read_elastic_law(*elastic, units_of_length.elastic()).value_or(Function{});
  if (damping && !add_term_with_signals(builder, part, *damping, LawOf::rate, "v", terms))
    spring.damping = read_damping_law(*damping, units_of_length.damper()).value_or(Function{});
  if (force) terms.emplace_back(*force, variables_of(LawOf::all));
  if (terms.empty()) return;
  if (auto general = read_formula(builder, part, terms, {"l", "v", "t"}, quantity::force)) {
    general->arguments.insert(general->arguments.begin(), spec::Source{});  // t
    spring.general = std::move(*general);
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
  if (const auto scale = fields.get("scale")) {
    if (uses_signals(builder, part, *scale))
      load.signal = anonymous_signal(builder, part, *scale, load.name + ".scale", quantity::number);
    else
      load.scale = read_law(*scale, LawOf::time, {quantity::time, quantity::number, quantity::number})
                       .value_or(Function{});
  }
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

template <class Item>
Item named(const std::string& name, const Mark& mark) {
  Item item;
  item.name = name;
  item.mark = mark;
  return item;
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

}  // namespace mimbre::model_file
