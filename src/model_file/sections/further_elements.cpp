#include <fmt/format.h>

#include <algorithm>

#include "joints/joint_kind.h"
#include "model_file/sections/elements.h"
#include "model_file/sections/signals.h"

/// Torsion springs, cables, motors and drag.
namespace mimbre::model_file {
namespace {

bool turns(const Builder& builder, int joint, int coordinate) {
  return is_angle(builder.model.joints[static_cast<std::size_t>(joint)].type, coordinate);
}

/// The keys of a law's numbers behind others.
std::vector<std::string> with_numbers(std::vector<std::string> keys, const LawInfo& law) {
  for (const LawNumber& number : law.numbers) keys.emplace_back(number.key);
  return keys;
}

/// Adds the signal that a text stands for to what the law takes.
void add_argument(Builder& builder, const Part& part, const Value& value, const std::string& name,
                  const Quantity& of, spec::Element& e) {
  const int signal = anonymous_signal(builder, part, value, fmt::format("{}.{}", e.name, name), of);
  if (signal >= 0) e.arguments.push_back({spec::Source::Kind::signal, signal});
}

void read_terms(Builder& builder, const Part& part, const Fields& fields, spec::Element& e) {
  const auto list = fields.need("coordinates", "[{joint: left}, {joint: right, factor: -1}]");
  if (!list) return;
  for (const Value& one : list->list()) {
    const Fields of(one, {"joint", "coordinate", "factor"});
    auto term = read_coordinate(builder, part, of);
    if (!term) continue;
    if (const auto factor = of.get("factor")) {
      term->factor = factor->number(quantity::any).value_or(1);
      if (term->factor == 0) factor->error("is 0, so that the coordinate is none; leave it out");
    }
    e.terms.push_back(*term);
  }
  if (list->is_list() && list->list().empty()) list->error("there is none; for example [{joint: left}]");
}

}  // namespace

void read_torsion_spring(Builder& builder, const Part& part, const Value& value, spec::Element& e) {
  const Fields fields(value, {"coordinates", "stiffness", "rest", "elastic", "damping"});
  if (!value.has_fields()) return;
  e.on = spec::Element::On::coordinates;
  read_terms(builder, part, fields, e);
  if (e.terms.empty()) return;
  const CoordinateUnits& units =
      turns(builder, e.terms[0].joint, e.terms[0].coordinate) ? units_of_angle : units_of_length;
  e.functions.assign(2, Function{});
  const auto stiffness = fields.get("stiffness"), elastic = fields.get("elastic"),
             damping = fields.get("damping");
  std::vector<FormulaTerm> terms;
  if (damping && !add_term_with_signals(builder, part, *damping, LawOf::rate, "v", terms))
    e.functions[1] = read_damping_law(*damping, units.damper()).value_or(Function{});
  const auto rest = fields.get("rest");
  if (stiffness) {
    const double k = stiffness->not_negative(units.stiffness).value_or(0);
    const bool moves = rest && !is_plain_number(*rest);
    e.functions[0] = Function::linear(k, moves ? 0 : fields.number("rest", 0, units.position));
    // k (x − rest): its own part k x stores energy, and −k rest works as a load does.
    if (moves) terms.push_back({*rest, variables_of(LawOf::time), -k, units.position});
    if (elastic) elastic->error("and 'stiffness' mean the same; keep one");
  } else if (elastic && !add_term_with_signals(builder, part, *elastic, LawOf::coordinate, "x", terms)) {
    e.functions[0] = read_elastic_law(*elastic, units.elastic()).value_or(Function{});
  }
  if (!stiffness && rest) rest->error("belongs to 'stiffness'");
  if (!stiffness && !elastic && !damping) value.error("specifies no force; for example stiffness: 1200");
  if (terms.empty()) return;
  if (auto general = read_formula(builder, part, terms, {"x", "v", "t"}, units.force)) {
    general->arguments.insert(general->arguments.begin(), spec::Source{});  // t
    e.general = std::move(*general);
  }
}

void read_cable(Builder& builder, const Part& part, const LawInfo& law, const Value& value,
                spec::Element& e) {
  const Fields fields(value, with_numbers({"over", "at"}, law));
  if (!value.has_fields()) return;
  e.on = spec::Element::On::path;
  const auto over = fields.need("over", "[ground, hook]");
  if (!over) return;
  const auto points = over->list();
  if (points.size() < 2) {
    if (over->is_list()) over->error("two bodies or frames are needed at least, for example [ground, hook]");
    return;
  }
  std::vector<std::optional<Value>> places(points.size());
  if (const auto at = fields.get("at")) {
    const auto list = at->list();
    if (list.size() != points.size()) {
      if (at->is_list())
        at->error(fmt::format("has {} places for {} points; ~ stands for none", list.size(), points.size()));
      return;
    }
    for (std::size_t k = 0; k < list.size(); ++k)
      if (!list[k].is_null()) places[k] = list[k];
  }
  for (std::size_t k = 0; k < points.size(); ++k) {
    const int frame = attach(builder, part, points[k], places[k], fmt::format("{}.{}", e.name, k + 1));
    if (frame < 0) return;
    e.path.push_back(frame);
  }
  const auto length = fields.get("length");
  const bool winch = length && !is_plain_number(*length);
  // The number of a length that a signal sets is not needed.
  e.numbers.clear();
  for (const LawNumber& number : law.numbers) {
    const std::string key(number.key);
    if (winch && key == "length") {
      e.numbers.push_back(0);
      continue;
    }
    LawInfo one = law;
    one.numbers = std::span(&number, 1);
    e.numbers.push_back(read_numbers(one, fields, value, false).front());
  }
  if (winch) {
    if (fields.has("preload")) fields.get("preload")->error("and 'length' mean the same; keep one");
    add_argument(builder, part, *length, "length", quantity::length, e);
  } else if (const std::string_view fault = law.fault(e.numbers); !fault.empty()) {
    value.error(std::string(fault));
  }
}

void read_motor(Builder& builder, const Part& part, const LawInfo& law, const Value& value,
                spec::Element& e) {
  const Fields fields(value, with_numbers({"joint", "coordinate", "curve", "command", "voltage"}, law));
  if (!value.has_fields() || !read_coordinate_of(builder, part, fields, e)) return;
  e.numbers = read_numbers(law, fields, value, turns(builder, e.joint, e.coordinate));
  const auto curve = fields.get("curve"), command = fields.get("command"), voltage = fields.get("voltage");
  if (curve.has_value() == fields.has("constant"))
    return value.error(
        "needs 'curve', its torque over its speed, or 'constant' and 'resistance' of a DC motor; one of "
        "both");
  if (const std::string_view fault = law.fault(e.numbers); !fault.empty())
    return value.error(std::string(fault));
  if (curve) {
    if (voltage)
      voltage->error("belongs to 'constant' and 'resistance'; a curve has a 'command' from -1 to 1");
    e.functions = {
        read_law(*curve, LawOf::rate, {quantity::turning_speed, quantity::moment, quantity::turning_damping})
            .value_or(Function{})};
    if (command)
      add_argument(builder, part, *command, "command", quantity::number, e);
    else
      value.error("'command' is missing: from -1 to 1, a number or an expression of t, inputs, signals");
    return;
  }
  if (command) command->error("belongs to a 'curve'; a DC motor has a 'voltage'");
  if (voltage)
    add_argument(builder, part, *voltage, "voltage", quantity::any, e);
  else
    value.error("'voltage' is missing, V: a number or an expression of t, inputs, signals and outputs");
}

void read_drag(Builder& builder, const Part& part, const LawInfo& law, const Value& value, spec::Element& e) {
  const Fields fields(value, {"on", "at", "x", "y", "z", "area", "density", "coefficients", "wind"});
  if (!value.has_fields()) return;
  e.on = spec::Element::On::velocity;
  const auto on = fields.need("on", "parachute");
  if (!on) return;
  e.frame_b = attach(builder, part, *on, fields.get("at"), e.name + ".frame");
  if (e.frame_b < 0) return;
  if (builder.model.frames[static_cast<std::size_t>(e.frame_b)].body == spec::ground)
    return on->error("is the ground, which drag cannot move; name a body");
  if (fields.has("x") || fields.has("y") || fields.has("z")) {
    const Eigen::Matrix3d axes = read_pose(part, fields, Eigen::Vector3d::Zero()).rotation;
    e.frame_b = turned_frame(builder, e.frame_b, e.name + ".axes", axes, *on);
    if (e.frame_b < 0) return;
  }
  LawInfo first = law;
  first.numbers = law.numbers.first(2);
  e.numbers = read_numbers(first, fields, value, false);
  const auto given = fields.need("coefficients", "[0.3, 0.8, 0.8]");
  if (!given) return;
  if (given->is_list()) {
    const auto three = given->numbers(3, 3);
    for (std::size_t k = 0; k < 3; ++k) e.numbers.push_back(three ? (*three)[k] : 0);
  } else {
    e.numbers.insert(e.numbers.end(), 3, given->number().value_or(0));
  }
  for (std::size_t k = 0; k < 3; ++k)
    if (const LawNumber& number = law.numbers[2 + k]; !number.allows(e.numbers[2 + k])) {
      given->error(wrong_number(number, e.numbers[2 + k]));
      break;
    }
  const auto wind = fields.get("wind");
  if (!wind) return;
  const auto parts = wind->list();
  if (parts.size() != 3) {
    if (wind->is_list()) wind->error("three components are needed, global: [vx, vy, vz]");
    return;
  }
  for (std::size_t k = 0; k < 3; ++k)
    add_argument(builder, part, parts[k], fmt::format("wind.{}", "xyz"[k]), quantity::speed, e);
}

}  // namespace mimbre::model_file
