#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <unordered_set>

#include "joints/axes.h"
#include "joints/joint_kind.h"
#include "math/turn.h"
#include "model_file/sections/signals.h"
#include "model_file/text/builder.h"
#include "spec/drive_start.h"

/// Joints, their drives, springs and initial values.
namespace mimbre::model_file {
namespace {

using spec::JointType;

/// Coordinates that are plain lengths or angles: those that drives, springs and outputs can name.
int scalar_coordinates(JointType type) {
  const JointInfo& info = joint_info(type);
  return info.quaternion >= 0 ? 0 : info.velocities;
}

const CoordinateUnits& units_of(JointType type, int coordinate) {
  return is_angle(type, coordinate) ? units_of_angle : units_of_length;
}

/// Whether a word is one of those, which spaces part.
bool is_among(std::string_view words, std::string_view word) {
  for (std::size_t at = 0; at < words.size();) {
    const std::size_t end = std::min(words.find(' ', at), words.size());
    if (words.substr(at, end - at) == word) return true;
    at = end + 1;
  }
  return false;
}

std::optional<JointType> read_type(const Fields& fields) {
  const auto type = fields.need("type", "revolute");
  if (!type) return {};
  const auto word = type->word();
  if (!word) return {};
  std::vector<std::string> names;
  for (const JointInfo* info : all_joints()) {
    if (is_among(info->elsewhere, *word)) {
      type->error(fmt::format("'{}' is called '{}' here", *word, info->name));
      return {};
    }
    names.emplace_back(info->name);
  }
  const auto choice = type->choice(names);
  if (!choice) return {};
  return all_joints()[static_cast<std::size_t>(*choice)]->type;
}

/// An axis of a joint's frames in its part: placed so that a mirrored joint's coordinates mean the same.
Eigen::Vector3d placed(const Part& part, const JointInfo& info, int axis, const Eigen::Vector3d& direction) {
  return info.is_vector(axis) ? part.place.vector(direction) : part.place.pseudo_vector(direction);
}

/// Joint axes from the given axis, and of types that have it the second.
std::optional<Eigen::Matrix3d> read_axes(const Part& part, const Value& axis,
                                         const std::optional<Value>& axis2, const JointInfo& info) {
  const auto first = axis.direction();
  if (!first) return {};
  if (info.implied) {
    Eigen::Matrix3d axes = joint_axes(info, *first);
    for (int k = 0; k < 3; ++k) axes.col(k) = placed(part, info, k, axes.col(k));
    return axes;
  }
  if (info.axes() < 2) return joint_axes(info, placed(part, info, info.given[0], *first));
  const auto second = axis2 ? axis2->direction() : std::nullopt;
  if (!second) return {};
  if (!perpendicular(*first, *second)) {
    axis2->error(
        fmt::format("axis and axis2 are not perpendicular: {} and {}", to_text(*first), to_text(*second)));
    return {};
  }
  return joint_axes(info, placed(part, info, info.given[0], *first),
                    placed(part, info, info.given[1], *second));
}

/// A frame of a mirrored template turned over so that joint coordinates mean the same as in the template (see
/// read_axes; the placed frame is M R M, these are R' M D).
Eigen::Matrix3d unmirrored_axes(const Part& part, const JointInfo& info, const Eigen::Matrix3d& axes) {
  Eigen::Vector3d signs;
  for (int k = 0; k < 3; ++k) signs[k] = info.is_vector(k) ? 1 : part.place.determinant();
  return axes * part.place.mirror.cwiseProduct(signs).asDiagonal();
}

/// The values of a key that may be given once or once for each of the two bodies.
std::optional<std::array<Value, 2>> for_both(const Value& value) {
  const auto items = value.list();
  if (items.empty() || !items.front().is_list()) return {{value, value}};
  if (items.size() == 2) return {{items[0], items[1]}};
  value.error(fmt::format("these are {} lists; one is needed for each of the two bodies", items.size()));
  return {};
}

bool is_pair(const Value& value) {
  return value.is_list() && !value.list().empty() && value.list().front().is_list();
}

/// The frames of bodies that are drawn apart: `at` has a point of each where it is drawn.
std::pair<int, int> read_apart(Builder& builder, const Part& part, const Fields& fields,
                               const std::array<int, 2>& bodies, const std::string& name,
                               const JointInfo& info) {
  const std::pair<int, int> none{-1, -1};
  const Value at = *fields.get("at");
  const auto points = for_both(at);
  const auto axis = fields.get("axis");
  const auto axis2 = info.axes() > 1 ? fields.need("axis2", "[0, 1, 0]") : std::nullopt;
  if (info.axes() > 0 && !axis)
    fields.error(
        fmt::format("'axis' is missing; a {} joint needs it, for example axis: [0, 1, 0]", info.name));
  const auto axes = axis ? for_both(*axis) : std::nullopt;
  const auto second = axis2 ? for_both(*axis2) : std::nullopt;
  if (!points || (info.axes() > 0 && !axes) || (info.axes() > 1 && !second)) return none;
  std::array<int, 2> made{-1, -1};
  for (std::size_t k = 0; k < 2; ++k) {
    const auto point = (*points)[k].triple(quantity::length);
    std::optional<Eigen::Matrix3d> rotation =
        Eigen::Matrix3d(part.place.determinant() * part.place.rotation * part.place.mirror.asDiagonal());
    if (axes)
      rotation =
          read_axes(part, (*axes)[k], second ? std::optional<Value>((*second)[k]) : std::nullopt, info);
    if (!point || !rotation) return none;
    const std::string frame_name = name + (k == 0 ? ".a" : ".b");
    made[k] = builder.add_frame_at(frame_name, bodies[k], part.place.point(*point), *rotation, (*points)[k]);
    builder.claim_end(builder.joint_names, part, name, k == 0 ? 'a' : 'b', (*points)[k].mark(), made[k]);
  }
  return {made[0], made[1]};
}

/// The two frames; -1 where something is wrong.
std::pair<int, int> read_between(Builder& builder, const Part& part, const Fields& fields,
                                 const std::string& name, JointType type) {
  const JointInfo& info = joint_info(type);
  const std::pair<int, int> none{-1, -1};
  const auto between = fields.need("between", "[ground, arm]");
  if (!between) return none;
  const auto pair = between->list();
  if (pair.size() != 2) {
    if (between->is_list()) between->error("two bodies or frames are needed, for example [ground, arm]");
    return none;
  }
  const auto a = resolve_attachment(builder, part, pair[0]), b = resolve_attachment(builder, part, pair[1]);
  if (!a || !b) return none;
  if (a->body == b->body) {
    between->error(a->body == spec::ground
                       ? "both sides are the ground; a joint needs a body"
                       : fmt::format("both sides are on body '{}'; a joint needs two bodies",
                                     builder.model.bodies[static_cast<std::size_t>(a->body)].name));
    return none;
  }
  const auto at = fields.get("at"), axis = fields.get("axis");
  const bool frames = a->frame >= 0 && b->frame >= 0;
  if (at && (a->frame >= 0 || b->frame >= 0)) {
    at->error("a frame has its place already; 'at' goes with the names of two bodies");
    return none;
  }
  if (fields.has("axis2") && info.axes() < 2)
    fields.get("axis2")->error(fmt::format("a {} joint has no second axis", info.name));
  if (axis && info.axes() == 0) {
    axis->error(fmt::format("a {} joint has no axis", info.name));
    return none;
  }
  if (at && is_pair(*at)) return read_apart(builder, part, fields, {a->body, b->body}, name, info);

  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  const int frame = a->frame >= 0 ? a->frame : b->frame;
  bool own_frame_b = false;  // the body's own frame, which moves with the tangent frame of a flexible body
  if (at) {
    const auto given = at->triple(quantity::length);
    if (!given) return none;
    place = part.place.point(*given);
  } else if (frame >= 0) {
    place = builder.global_pose(frame).position;
  } else if (info.any_place) {
    place = builder.body_pose(b->body).position;
    own_frame_b = info.free() && b->body != spec::ground;
  } else {
    fields.error(
        "'at' is missing; where two bodies are named the joint needs its place, for example at: [0, 0, 0]");
    return none;
  }

  std::optional<Eigen::Matrix3d> axes;
  if (axis) {
    axes = read_axes(part, *axis, info.axes() > 1 ? fields.need("axis2", "[0, 1, 0]") : std::nullopt, info);
    if (!axes) return none;
  } else if (frame < 0 && info.axes() > 0) {
    fields.error(
        fmt::format("'axis' is missing; a {} joint needs it, for example axis: [0, 1, 0]", info.name));
    return none;
  } else if (frame < 0) {
    axes = info.free() ? builder.body_pose(b->body).rotation
                       : Eigen::Matrix3d(part.place.determinant() * part.place.rotation *
                                         part.place.mirror.asDiagonal());
  }

  const bool mirrored = (part.place.mirror.array() < 0).any();
  const auto side = [&](const Attachment& attachment, const char* letter, bool own) {
    const bool reuse = attachment.frame >= 0 && !axes && !(mirrored && !info.free());
    if (reuse) return attachment.frame;
    if (own && !frames)
      return builder.frame_names.index.at(
          builder.model.bodies[static_cast<std::size_t>(attachment.body)].name);
    const spec::Pose there = attachment.frame >= 0 ? builder.global_pose(attachment.frame)
                             : frame >= 0          ? builder.global_pose(frame)
                                                   : spec::Pose{place, Eigen::Matrix3d::Identity()};
    const Eigen::Matrix3d rotation = axes       ? *axes
                                     : mirrored ? unmirrored_axes(part, info, there.rotation)
                                                : there.rotation;
    const std::string frame_name = name + "." + letter;
    const Value& where = at ? *at : pair[letter[0] == 'a' ? 0 : 1];
    const int made = builder.add_frame_at(frame_name, attachment.body, there.position, rotation, where);
    builder.claim_end(builder.joint_names, part, name, letter[0], where.mark(), made);
    return made;
  };
  const int frame_a = side(*a, "a", false);
  const int frame_b = side(*b, "b", own_frame_b);
  return {frame_a, frame_b};
}

std::optional<int> read_coordinate(const Fields& fields, JointType type) {
  const int count = scalar_coordinates(type);
  if (count == 0) {
    fields.error(fmt::format("a {} joint has no scalar coordinate to act on", joint_info(type).name));
    return {};
  }
  if (const auto coordinate = fields.get("coordinate")) return coordinate->integer(0, count - 1);
  if (count > 1) fields.error(fmt::format("the joint has {} coordinates; choose one: coordinate: 0", count));
  return 0;
}

/// One map or a list of maps.
std::vector<Value> one_or_many(const Value& value) {
  if (value.is_list()) return value.list();
  return {value};
}

void read_drives(Builder& builder, const Part& part, const Value& value, spec::Joint& joint) {
  std::unordered_set<int> driven;
  for (const Value& item : one_or_many(value)) {
    const Fields fields(item, {"position", "speed", "coordinate"});
    if (!item.has_fields()) continue;
    const auto coordinate = read_coordinate(fields, joint.type);
    const auto position = fields.get("position"), speed = fields.get("speed");
    if (position.has_value() == speed.has_value())
      item.error(position ? "has both 'position' and 'speed'; keep one"
                          : "'position' or 'speed' is missing, for example position: \"0.5*sin(2*pi*t)\"");
    if (position.has_value() == speed.has_value() || !coordinate) continue;
    if (!driven.insert(*coordinate).second)
      item.error(fmt::format("coordinate {} is driven twice", *coordinate));
    const CoordinateUnits& units = units_of(joint.type, *coordinate);
    const Value& law = position ? *position : *speed;
    if (uses_signals(builder, part, law)) {
      spec::Drive drive;
      drive.coordinate = *coordinate;
      drive.of = position ? spec::Drive::Of::position : spec::Drive::Of::speed;
      drive.signal = anonymous_signal(builder, part, law, fmt::format("{}.drive.{}", joint.name, *coordinate),
                                      position ? units.position : units.velocity);
      joint.drives.push_back(std::move(drive));
      continue;
    }
    if (auto function = read_law(position ? *position : *speed, LawOf::time,
                                 position ? units.drive() : units.speed_drive()))
      joint.drives.push_back({*coordinate, std::move(*function),
                              position ? spec::Drive::Of::position : spec::Drive::Of::speed, -1});
  }
}

/// What a drive prescribes needs no initial value, and one that is something else would be ignored.
void check_driven(const spec::Model& model, const Fields& fields, const spec::Joint& joint) {
  const auto check = [&](bool rate, const spec::Drive& drive, double driven) {
    const auto& given = rate ? joint.initial_velocity : joint.initial_position;
    const auto k = static_cast<std::size_t>(drive.coordinate);
    if (k >= given.size() || !given[k] ||
        !contradicts_drive(model, joint.type, drive.coordinate, rate, *given[k], driven))
      return;
    fields.get(rate ? "velocity" : "position")
        ->error(fmt::format("{} contradicts the drive, which starts with {:.6g}; leave it out{}", *given[k],
                            driven, given.size() > 1 ? " (null)" : ""));
  };
  for (const spec::Drive& drive : joint.drives) {
    if (drive.signal >= 0) continue;  // known with its inputs only
    const bool position = drive.of == spec::Drive::Of::position;
    if (position) check(false, drive, drive.law.value(0));
    check(true, drive, position ? drive.law.derivative(0) : drive.law.value(0));
  }
}

void read_joint_springs(Builder& builder, const Part& part, const Value& value, spec::Joint& joint) {
  for (const Value& item : one_or_many(value)) {
    const Fields fields(item, {"stiffness", "damping", "zero", "elastic", "coordinate"});
    if (!item.has_fields()) continue;
    const auto coordinate = read_coordinate(fields, joint.type);
    spec::JointSpring spring;
    spring.coordinate = coordinate.value_or(0);
    const CoordinateUnits& units = units_of(joint.type, spring.coordinate);
    const auto stiffness = fields.get("stiffness"), elastic = fields.get("elastic"),
               damping = fields.get("damping");
    if (!stiffness && !elastic && !damping)
      item.error("specifies no force; for example {stiffness: 100, damping: 1, zero: 0}");
    if (stiffness && elastic) item.error("has both 'stiffness' and 'elastic'; keep one");
    if (!stiffness && fields.has("zero")) item.error("'zero' belongs to 'stiffness', which is missing");
    if (stiffness)
      spring.elastic = Function::linear(stiffness->not_negative(units.stiffness).value_or(0),
                                        fields.number("zero", 0, units.position));
    std::vector<FormulaTerm> terms;
    if (elastic && !add_term_with_signals(builder, part, *elastic, LawOf::coordinate, "x", terms))
      spring.elastic = read_elastic_law(*elastic, units.elastic()).value_or(Function{});
    if (damping && !add_term_with_signals(builder, part, *damping, LawOf::rate, "v", terms))
      spring.damping = read_damping_law(*damping, units.damper()).value_or(Function{});
    if (!terms.empty())
      spring.general = read_formula(builder, part, terms, {"x", "v"}, units.force).value_or(spec::Law{});
    if (coordinate) joint.springs.push_back(std::move(spring));
  }
}

/// One number or a list with nulls, one entry per velocity coordinate.
std::vector<std::optional<double>> read_initial(const Value& value, JointType type,
                                                const Quantity CoordinateUnits::*of) {
  const int count = joint_info(type).velocities;
  std::vector<std::optional<double>> result;
  if (count == 0) {
    value.error(fmt::format("a {} joint has no coordinates", joint_info(type).name));
  } else if (value.is_list()) {
    for (const Value& item : value.list()) {
      const int k = std::min(static_cast<int>(result.size()), count - 1);
      result.push_back(item.is_null() ? std::nullopt : item.number(units_of(type, k).*of));
    }
    if (static_cast<int>(result.size()) != count) {
      value.error(
          fmt::format("{} values are needed (null where it is free), these are {}", count, result.size()));
      result.clear();
    }
  } else if (count == 1) {
    result.push_back(value.number(units_of(type, 0).*of));
  } else {
    value.error(fmt::format("a list of {} values is needed (null where it is free)", count));
  }
  return result;
}

std::optional<Eigen::Vector3d> three(const std::vector<std::optional<double>>& values, std::size_t first) {
  if (values.size() < first + 3 || !values[first] || !values[first + 1] || !values[first + 2]) return {};
  return Eigen::Vector3d(*values[first], *values[first + 1], *values[first + 2]);
}

void put(const Eigen::Vector3d& v, std::vector<std::optional<double>>& values, std::size_t first) {
  for (std::size_t k = 0; k < 3; ++k) values[first + k] = v[static_cast<Eigen::Index>(k)];
}

/// A floating joint's velocities are given in global axes; the joint wants a's axes and b's axes. Its
/// position is given in a's axes and is mirrored like the frames.
void place_floating(const Builder& builder, const Part& part, const Value& value, spec::Joint& joint) {
  for (auto* position : {&joint.initial_position, &joint.near}) {
    if (const auto p = three(*position, 0)) put(part.place.mirror.cwiseProduct(*p), *position, 0);
    if (const auto r = three(*position, 3))
      put(part.place.determinant() * part.place.mirror.cwiseProduct(*r), *position, 3);
  }
  auto& velocity = joint.initial_velocity;
  if (velocity.empty()) return;
  const auto linear = three(velocity, 0), angular = three(velocity, 3);
  const auto any = [&](std::size_t first) {
    return velocity[first] || velocity[first + 1] || velocity[first + 2];
  };
  if ((!linear && any(0)) || (!angular && any(3)))
    value.error(
        "give all three components of a floating joint's linear velocity, and of its angular velocity, or "
        "none");
  const Eigen::Matrix3d a = builder.global_pose(joint.frame_a).rotation;
  if (linear) put(a.transpose() * part.place.vector(*linear), velocity, 0);
  if (angular) {
    const Eigen::Matrix3d b = a * turn_by(three(joint.initial_position, 3).value_or(Eigen::Vector3d::Zero()));
    put(b.transpose() * part.place.pseudo_vector(*angular), velocity, 3);
  }
}

void read_joint(Builder& builder, const Part& part, const Value& value, spec::Joint& joint) {
  const Fields fields(value, {"type", "between", "at", "axis", "axis2", "cut", "position", "velocity", "near",
                              "drive", "spring"});
  if (!value.has_fields()) return;
  const auto type = read_type(fields);
  if (!type) {
    // Wrong names are worth saying all the same.
    if (const auto between = fields.get("between"); between && between->is_list())
      for (const Value& side : between->list()) resolve_attachment(builder, part, side);
    return;
  }
  joint.type = *type;
  std::tie(joint.frame_a, joint.frame_b) = read_between(builder, part, fields, joint.name, *type);
  if (const auto cut = fields.get("cut"))
    if (const auto choice = cut->choice({"automatic", "never", "always"}))
      joint.cut = static_cast<spec::Joint::Cut>(*choice);
  if (const auto drive = fields.get("drive")) read_drives(builder, part, *drive, joint);
  if (const auto spring = fields.get("spring")) read_joint_springs(builder, part, *spring, joint);
  if (const auto position = fields.get("position"))
    joint.initial_position = read_initial(*position, *type, &CoordinateUnits::position);
  if (const auto near = fields.get("near"))
    joint.near = read_initial(*near, *type, &CoordinateUnits::position);
  if (const auto at = fields.get("at")) joint.apart = is_pair(*at);
  if (const auto velocity = fields.get("velocity"))
    joint.initial_velocity = read_initial(*velocity, *type, &CoordinateUnits::velocity);
  check_driven(builder.model, fields, joint);
  if (joint_info(joint.type).free() && joint.frame_a >= 0 && joint.frame_b >= 0)
    place_floating(builder, part, value, joint);
}

}  // namespace

void read_joints(Builder& builder, Part& part) {
  const auto section = part.section("joints");
  if (!section) return;
  if (!section->is_map()) return section->error("names with their descriptions are needed");
  for (const auto& entry : section->tree().entries) {
    spec::Joint joint;
    joint.name = part.full_name(entry.key);
    joint.mark = entry.mark;
    if (!builder.claim(builder.joint_names, part, joint.name, entry.mark,
                       static_cast<int>(builder.model.joints.size())))
      continue;
    read_joint(builder, part, Value(part.reading, *entry.value, fmt::format("joint '{}'", joint.name)),
               joint);
    builder.model.joints.push_back(std::move(joint));
  }
}

void add_floating_joints(Builder& builder) {
  spec::Model& model = builder.model;
  std::vector<bool> joined_bodies(model.bodies.size(), false);
  for (const spec::Joint& joint : model.joints)
    for (const int frame : {joint.frame_a, joint.frame_b})
      if (frame >= 0 && model.frames[static_cast<std::size_t>(frame)].body >= 0)
        joined_bodies[static_cast<std::size_t>(model.frames[static_cast<std::size_t>(frame)].body)] = true;
  const Part& part = builder.parts.front();
  for (std::size_t k = 0; k < model.bodies.size(); ++k) {
    if (joined_bodies[k]) continue;
    const spec::Body& body = model.bodies[k];
    spec::Joint joint;
    joint.name = body.name + ".floating";
    joint.mark = body.mark;
    joint.type = JointType::floating;
    spec::Frame frame;
    frame.name = joint.name + ".a";
    frame.mark = body.mark;
    frame.pose = body.pose;
    joint.frame_a = builder.add_frame(std::move(frame));
    joint.frame_b = builder.frame_names.index.at(body.name);
    builder.claim_end(builder.joint_names, part, joint.name, 'a', joint.mark, joint.frame_a);
    builder.claim(builder.joint_names, part, joint.name, joint.mark, static_cast<int>(model.joints.size()));
    model.joints.push_back(std::move(joint));
  }
}

}  // namespace mimbre::model_file
