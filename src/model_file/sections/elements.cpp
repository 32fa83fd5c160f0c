#include "model_file/sections/elements.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <tuple>

#include "joints/joint_kind.h"
#include "math/once/decompositions.h"
#include "model_file/sections/signals.h"
#include "spec/force_law.h"
#include "spec/nearest_place.h"

/// Actuators and bushings.
namespace mimbre::model_file {

std::pair<int, int> read_ends(Builder& builder, const Part& part, const Fields& fields,
                              const std::string& name, bool one_place) {
  constexpr std::pair none{-1, -1};
  const auto between = fields.need("between", "[arm, chassis]");
  if (!between) return none;
  const auto pair = between->list();
  if (pair.size() != 2) {
    if (between->is_list()) between->error("two bodies or frames are needed, for example [arm, chassis]");
    return none;
  }
  std::vector<std::optional<Value>> places(2);
  if (const auto at = fields.get("at")) {
    if (one_place) {
      places[0] = places[1] = *at;
    } else {
      const auto list = at->list();
      if (list.size() != 2) {
        if (at->is_list()) at->error("two places are needed: [[x, y, z], [x, y, z]]");
        return none;
      }
      for (std::size_t k = 0; k < 2; ++k)
        if (!list[k].is_null()) places[k] = list[k];
    }
  }
  const int a = attach(builder, part, pair[0], places[0], name + ".a");
  const int b = attach(builder, part, pair[1], places[1], name + ".b");
  if (a < 0 || b < 0) return none;
  const auto body = [&](int frame) { return builder.model.frames[static_cast<std::size_t>(frame)].body; };
  const Eigen::Vector3d here = builder.global_pose(a).position, there = builder.global_pose(b).position;
  if (!one_place && at_one_place(here, there)) {
    fields.error(
        fmt::format("has length zero: both ends are at {}; it needs a direction to pull in", to_text(here)));
  } else if (body(a) == spec::ground && body(b) == spec::ground) {
    between->error("both ends are on the ground");
    return none;
  }
  return {a, b};
}

std::optional<std::pair<int, int>> read_coordinate(Builder& builder, const Part& part, const Value& joint,
                                                   const std::optional<Value>& coordinate) {
  const auto name = joint.word();
  const int number = name ? builder.resolve(builder.joint_names, part, *name, joint) : -1;
  if (number < 0) return {};
  const JointInfo& info = joint_info(builder.model.joints[static_cast<std::size_t>(number)].type);
  const int count = info.quaternion < 0 ? info.velocities : info.quaternion;
  if (count == 0) {
    joint.error(fmt::format("a {} joint has no scalar coordinate to act on", info.name));
    return {};
  }
  if (coordinate) return std::pair(number, coordinate->integer(0, count - 1).value_or(0));
  if (count > 1) joint.error(fmt::format("the joint has {} coordinates; choose one: coordinate: 0", count));
  return std::pair(number, 0);
}

int turned_frame(Builder& builder, int frame, const std::string& name, const Eigen::Matrix3d& axes,
                 const Value& value) {
  const int body = builder.model.frames[static_cast<std::size_t>(frame)].body;
  return builder.add_frame_at(name, body, builder.global_pose(frame).position, axes, value);
}

std::optional<spec::Element::Term> read_coordinate(Builder& builder, const Part& part, const Fields& fields) {
  spec::Element::Term term;
  const auto joint = fields.need("joint", "hinge");
  const auto found = joint ? read_coordinate(builder, part, *joint, fields.get("coordinate")) : std::nullopt;
  if (!found) return {};
  std::tie(term.joint, term.coordinate) = *found;
  return term;
}

bool read_coordinate_of(Builder& builder, const Part& part, const Fields& fields, spec::Element& e) {
  const auto term = read_coordinate(builder, part, fields);
  if (!term) return false;
  e.on = spec::Element::On::coordinate;
  e.joint = term->joint;
  e.coordinate = term->coordinate;
  return true;
}

namespace {

void read_actuator(Builder& builder, const Part& part, const Value& value, spec::Element& e) {
  const Fields fields(
      value, {"joint", "coordinate", "between", "at", "along", "about", "force", "torque", "moment"});
  if (!value.has_fields()) return;
  e.law = "actuator";
  const auto joint = fields.get("joint"), between = fields.get("between"), along = fields.get("along"),
             about = fields.get("about");
  auto force = fields.get("force"), torque = fields.get("torque");
  if (!torque) torque = fields.get("moment");
  if (force.has_value() == torque.has_value())
    value.error(
        "needs 'force' or 'torque', one of them: a number or an expression of t, inputs, signals and "
        "outputs");
  if (joint.has_value() == between.has_value())
    return value.error("acts on a 'joint', or 'between' two bodies or frames; give one of them");
  bool turns = false;
  if (joint) {
    if (!read_coordinate_of(builder, part, fields, e)) return;
    const spec::JointType type = builder.model.joints[static_cast<std::size_t>(e.joint)].type;
    turns = is_angle(type, e.coordinate);
    if (along || about) value.error("'along' and 'about' belong to 'between'");
  } else {
    if (along && about) value.error("has both 'along' and 'about'; keep one");
    const bool axis = along || about;
    std::tie(e.frame_a, e.frame_b) = read_ends(builder, part, fields, e.name, axis);
    if (e.frame_a < 0) return;
    e.on = axis ? spec::Element::On::axis : spec::Element::On::line;
    e.about = turns = about.has_value();
    if (axis) {
      const auto direction = (along ? *along : *about).direction();
      if (!direction) return;
      const Eigen::Vector3d global =
          along ? part.place.vector(*direction) : part.place.pseudo_vector(*direction);
      e.direction = builder.global_pose(e.frame_a).rotation.transpose() * global;
    }
  }
  if (force && turns) force->error("is a torque here, about an angle: write 'torque'");
  if (torque && !turns) torque->error("is a force here, along a length: write 'force'");
  const auto& command_value = force ? force : torque;
  if (!command_value) return;
  const int signal = anonymous_signal(builder, part, *command_value, fmt::format("{}.command", e.name),
                                      turns ? quantity::moment : quantity::force);
  if (signal >= 0) e.arguments = {{spec::Source::Kind::signal, signal}};
}

/// Six numbers of the diagonal, or six rows of six.
std::optional<Eigen::Matrix<double, 6, 6>> read_six(const Value& value, bool linear_time) {
  Eigen::Matrix<double, 6, 6> m = Eigen::Matrix<double, 6, 6>::Zero();
  const auto list = value.list();
  if (list.size() != 6) {
    if (value.is_list())
      value.error("six numbers are needed, of x, y, z and the turns about them, or six rows of six");
    return {};
  }
  bool good = true;
  for (int r = 0; r < 6; ++r) {
    const Value& row = list[static_cast<std::size_t>(r)];
    if (row.is_list()) {
      const auto numbers = row.numbers(6, 6);
      good = good && numbers;
      for (int c = 0; c < 6 && numbers; ++c) m(r, c) = (*numbers)[static_cast<std::size_t>(c)];
    } else {
      const Quantity& of = linear_time ? (r < 3 ? quantity::damping : quantity::turning_damping)
                                       : (r < 3 ? quantity::stiffness : quantity::turning_stiffness);
      const auto number = row.not_negative(of);
      good = good && number;
      m(r, r) = number.value_or(0);
    }
  }
  if (!good) return {};
  const double size = m.cwiseAbs().maxCoeff();
  if ((m - m.transpose()).cwiseAbs().maxCoeff() > 1e-9 * size) {
    value.error("is not symmetric: a force law with such a matrix would make energy from nothing");
    return {};
  }
  m = (0.5 * (m + m.transpose())).eval();
  if (PivotedCholesky(m).least_pivot() < -1e-9 * size) {
    value.error("is not positive: pushed in some direction it would push further");
    return {};
  }
  return m;
}

void read_bushing(Builder& builder, const Part& part, const Value& value, spec::Element& e) {
  const Fields fields(value, {"between", "at", "x", "y", "z", "stiffness", "damping", "laws", "maxwell"});
  if (!value.has_fields()) return;
  e.law = "bushing";
  e.on = spec::Element::On::frames;
  std::tie(e.frame_a, e.frame_b) = read_ends(builder, part, fields, e.name, true);
  if (e.frame_a < 0) return;
  const Value between = *fields.get("between");
  const Eigen::Matrix3d axes = read_pose(part, fields, Eigen::Vector3d::Zero()).rotation;
  const bool turned = fields.has("x") || fields.has("y") || fields.has("z");
  // The ground's axes in a part are those of the part.
  if (turned || (between.list().front().word() == "ground" && !axes.isIdentity()))
    e.frame_a = turned_frame(builder, e.frame_a, e.name + ".axes", axes, between);
  if (e.frame_a < 0) return;
  e.numbers.assign(72, 0.0);
  const auto put = [&](const char* key, bool rate, std::size_t first) {
    const auto given = fields.get(key);
    if (!given) return;
    if (const auto m = read_six(*given, rate))
      for (int r = 0; r < 6; ++r)
        for (int c = 0; c < 6; ++c) e.numbers[first + static_cast<std::size_t>(6 * r + c)] = (*m)(r, c);
  };
  put("stiffness", false, 0);
  put("damping", true, 36);
  const auto laws = fields.get("laws");
  if (laws) {
    const std::array names{"x", "y", "z", "rx", "ry", "rz"};
    const Fields each(*laws, {"x", "y", "z", "rx", "ry", "rz"});
    e.functions.assign(12, Function{});
    for (std::size_t k = 0; k < 6; ++k) {
      const auto law = each.get(names[k]);
      if (!law) continue;
      const Fields of(*law, {"elastic", "damping"});
      const CoordinateUnits& units = k < 3 ? units_of_length : units_of_angle;
      if (const auto elastic = of.get("elastic"))
        e.functions[k] = read_elastic_law(*elastic, units.elastic()).value_or(Function{});
      if (const auto damping = of.get("damping"))
        e.functions[6 + k] = read_damping_law(*damping, units.damper()).value_or(Function{});
    }
  }
  if (const auto maxwell = fields.get("maxwell"))
    for (const Value& branch : maxwell->list()) {
      const Fields of(branch, {"stiffness", "relaxation"});
      const auto stiffness = of.need("stiffness", "[1e6, 1e6, 1e6, 100, 100, 100]"),
                 relaxation = of.need("relaxation", "0.01");
      if (!stiffness || !relaxation) continue;
      const auto m = read_six(*stiffness, false);
      const auto time = relaxation->positive(quantity::time);
      if (m && time) e.branches.push_back({*m, *time});
    }
  if (!fields.has("stiffness") && !fields.has("damping") && !laws && !fields.has("maxwell"))
    value.error("specifies no force; for example stiffness: [1e6, 1e6, 1e6, 500, 500, 500]");
}

/// A unit of the table as a quantity; any where that is no unit. `turns`: on an angle.
Quantity quantity_of(std::string_view unit, bool turns) {
  if (const std::size_t bar = unit.find('|'); bar != unit.npos)
    unit = turns ? unit.substr(bar + 1) : unit.substr(0, bar);
  if (unit.empty()) return quantity::number;
  const std::string text = "1 " + std::string(unit);
  const auto read = read_unit(text, 2, [](const std::string&) { return false; });
  return {unit, read ? std::optional(read->dimension) : std::nullopt};
}

}  // namespace

std::vector<double> read_numbers(std::span<const LawNumber> numbers, const Fields& fields, const Value& value,
                                 bool turns, bool may_miss) {
  std::vector<double> all;
  for (const LawNumber& number : numbers) {
    const std::string key(number.key);
    const Quantity of = quantity_of(number.unit, turns);
    double read = number.otherwise;
    if (const auto given = fields.get(key)) {
      if (const auto x = given->number(of)) {
        read = *x;
        if (!number.allows(read)) given->error(wrong_number(number, read));
      }
    } else if (std::isnan(read) && !may_miss) {
      value.error(fmt::format("'{}' is missing: {}, {}", key, number.about,
                              number.unit.empty() ? "a number" : of.unit));
      read = 0;
    }
    all.push_back(read);
  }
  return all;
}

namespace {

/// The force that a law takes, by a number or an expression of signals.
void read_force(Builder& builder, const Part& part, const Fields& fields, const Value& value, bool turns,
                spec::Element& e) {
  const char *right = turns ? "torque" : "force", *wrong = turns ? "force" : "torque";
  if (const auto other = fields.get(wrong))
    other->error(fmt::format("is a {} here, {}: write '{}'", right,
                             turns ? "about an angle" : "along a length", right));
  const auto given = fields.get(right);
  if (!given) {
    if (!fields.has(wrong))
      value.error(fmt::format("'{}' is missing: a number, or an expression of t, inputs, signals and outputs",
                              right));
    return;
  }
  const int signal = anonymous_signal(builder, part, *given, fmt::format("{}.{}", e.name, right),
                                      turns ? quantity::moment : quantity::force);
  if (signal >= 0) e.arguments = {{spec::Source::Kind::signal, signal}};
}

/// A law that its numbers describe: along the line between two frames, or on a joint's coordinate.
void read_plain(Builder& builder, const Part& part, const LawInfo& law, const Value& value,
                spec::Element& e) {
  std::vector<std::string> keys;
  if (law.along) keys.insert(keys.end(), {"between", "at"});
  if (law.coordinate) keys.insert(keys.end(), {"joint", "coordinate"});
  if (law.arguments > 0) keys.insert(keys.end(), {"force", "torque"});
  for (const LawNumber& number : law.numbers) keys.emplace_back(number.key);
  const Fields fields(value, keys);
  if (!value.has_fields()) return;
  bool turns = false;
  if (law.coordinate && (fields.has("joint") || !law.along)) {
    if (!read_coordinate_of(builder, part, fields, e)) return;
    turns = is_angle(builder.model.joints[static_cast<std::size_t>(e.joint)].type, e.coordinate);
    if (fields.has("between"))
      value.error("acts on a 'joint', or 'between' two bodies or frames; give one of them");
  } else {
    std::tie(e.frame_a, e.frame_b) = read_ends(builder, part, fields, e.name, false);
  }
  e.numbers = read_numbers(law.numbers, fields, value, turns);
  if (law.arguments > 0) read_force(builder, part, fields, value, turns, e);
}

}  // namespace

std::vector<std::string> with_element_sections(std::vector<std::string> before,
                                               const std::vector<std::string>& behind) {
  for (const LawInfo* law : all_laws())
    if (!law->section.empty()) before.emplace_back(law->section);
  before.insert(before.end(), behind.begin(), behind.end());
  return before;
}

void read_elements(Builder& builder, Part& part) {
  for (const LawInfo* info : all_laws()) {
    const LawInfo& law = *info;
    if (law.section.empty()) continue;
    const std::string section(law.section), kind(law.name);
    Names& names = builder.element_names[section];
    names.kind = kind;
    std::size_t count = builder.model.elements.size();
    for_each(builder, part, section, names, count,
             [&](const auto& name, const Mark& mark, const Value& value) {
               spec::Element e;
               e.name = name;
               e.mark = mark;
               e.law = kind;
               if (kind == "actuator")
                 read_actuator(builder, part, value, e);
               else if (kind == "bushing")
                 read_bushing(builder, part, value, e);
               else if (kind == "torsion_spring")
                 read_torsion_spring(builder, part, value, e);
               else if (kind == "cable")
                 read_cable(builder, part, law, value, e);
               else if (kind == "motor")
                 read_motor(builder, part, law, value, e);
               else if (kind == "drag")
                 read_drag(builder, part, law, value, e);
               else
                 read_plain(builder, part, law, value, e);
               builder.model.elements.push_back(std::move(e));
             });
  }
}

}  // namespace mimbre::model_file
