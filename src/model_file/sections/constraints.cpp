#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "joints/axes.h"
#include "joints/joint_kind.h"
#include "model_file/sections/elements.h"
#include "spec/constraint_kind.h"
#include "spec/coupling_uses.h"

/// Constraints between bodies, and couplings of joint coordinates by their uses: gears, racks, differentials.
namespace mimbre::model_file {
namespace {

/// Uses of a coupling that have a name, behind the kinds.
constexpr std::array uses{"gear", "rack", "differential"};

/// The coordinate of a joint that is named alone: `coordinate` where it has several.
std::optional<spec::Constraint::Term> read_joint_of(Builder& builder, const Part& part, const Value& joint,
                                                    const std::optional<Value>& coordinate) {
  const auto found = read_coordinate(builder, part, joint, coordinate);
  if (!found) return {};
  return spec::Constraint::Term{found->first, found->second, 1};
}

/// `joints: [a, b]`, with `coordinates: [0, 1]` where they have several.
std::vector<spec::Constraint::Term> read_coupled(Builder& builder, const Part& part, const Fields& fields,
                                                 std::size_t count, const char* example) {
  const auto joints = fields.need("joints", example);
  if (!joints) return {};
  const auto names = joints->list();
  if (names.size() != count) {
    if (joints->is_list()) joints->error(fmt::format("{} joints are needed, for example {}", count, example));
    return {};
  }
  std::vector<Value> coordinates;
  if (const auto given = fields.get("coordinates")) {
    coordinates = given->list();
    if (coordinates.size() != count) {
      if (given->is_list()) given->error(fmt::format("{} are needed, one for each joint", count));
      return {};
    }
  }
  std::vector<spec::Constraint::Term> terms;
  for (std::size_t k = 0; k < count; ++k) {
    const auto coordinate =
        coordinates.empty() || coordinates[k].is_null() ? std::nullopt : std::optional(coordinates[k]);
    if (const auto term = read_joint_of(builder, part, names[k], coordinate)) terms.push_back(*term);
  }
  return terms.size() == count ? terms : std::vector<spec::Constraint::Term>();
}

template <std::size_t n>
void set_factors(spec::Constraint& c, const std::array<double, n>& factors) {
  for (std::size_t k = 0; k < n; ++k) c.terms[k].factor = factors[k];
}

bool turns(const Builder& builder, const spec::Constraint::Term& term) {
  return is_angle(builder.model.joints[static_cast<std::size_t>(term.joint)].type, term.coordinate);
}

/// θ1 = ratio · θ2.
void read_gear(Builder& builder, const Part& part, const Value& value, spec::Constraint& c) {
  const Fields fields(value, {"type", "joints", "coordinates", "ratio", "teeth", "internal", "constant"});
  c.terms = read_coupled(builder, part, fields, 2, "[pinion, wheel]");
  const auto ratio = fields.get("ratio"), teeth = fields.get("teeth"), internal = fields.get("internal");
  if (ratio.has_value() == teeth.has_value())
    return value.error(
        "needs 'ratio', the first joint's speed over the second's, or 'teeth', of both; give one of them");
  double of = 1;
  if (ratio) {
    of = ratio->number().value_or(1);
    if (of == 0)
      ratio->error("is 0, so that the first joint could not turn at all; lock it by a drive instead");
    if (internal) internal->error("belongs to 'teeth'; a ratio has its sign");
  } else {
    const auto numbers = teeth->numbers(2, 2);
    if (!numbers) return;
    if (!((*numbers)[0] > 0 && (*numbers)[1] > 0)) return teeth->error("have to be two positive numbers");
    const bool inside = internal && internal->flag().value_or(false);
    of = (inside ? 1 : -1) * (*numbers)[1] / (*numbers)[0];
  }
  if (c.terms.empty()) return;
  if (turns(builder, c.terms[0]) != turns(builder, c.terms[1]))
    return value.error("one of the joints turns and the other slides; that is a rack: type: rack");
  set_factors(c, gear_factors(of));
}

/// x = travel · θ / 2π.
void read_rack(Builder& builder, const Part& part, const Value& value, spec::Constraint& c) {
  const Fields fields(value, {"type", "joints", "coordinates", "radius", "travel", "constant"});
  c.terms = read_coupled(builder, part, fields, 2, "[pinion, rack]");
  const auto radius = fields.get("radius"), travel = fields.get("travel");
  if (radius.has_value() == travel.has_value())
    return value.error(
        "needs 'radius', of the pinion, or 'travel', of the rack for each turn; give one of them");
  const auto length = (radius ? *radius : *travel).number(quantity::length);
  if (length && *length == 0) (radius ? *radius : *travel).error("is 0, so that the rack would not move");
  if (c.terms.empty() || !length) return;
  if (!turns(builder, c.terms[0]) || turns(builder, c.terms[1]))
    return value.error("needs a joint that turns, the pinion, and then one that slides, the rack");
  set_factors(c, rack_factors(radius ? *length : *length / (2 * std::numbers::pi)));
}

/// The cage turns with the mean of both sides.
void read_differential(Builder& builder, const Part& part, const Value& value, spec::Constraint& c) {
  const Fields fields(value, {"type", "joints", "coordinates", "constant"});
  c.terms = read_coupled(builder, part, fields, 3, "[cage, left, right]");
  if (!c.terms.empty()) set_factors(c, differential_factors);
}

void read_coupling(Builder& builder, const Part& part, const Value& value, spec::Constraint& c) {
  const Fields fields(value, {"type", "terms", "constant"});
  const auto terms = fields.need("terms", "[{joint: a, factor: 1}, {joint: b, factor: -2}]");
  if (!terms) return;
  for (const Value& item : terms->list()) {
    const Fields of(item, {"joint", "coordinate", "factor"});
    if (!item.has_fields()) continue;
    const auto joint = of.need("joint", "hinge");
    if (!joint) continue;
    auto term = read_joint_of(builder, part, *joint, of.get("coordinate"));
    if (!term) continue;
    if (const auto factor = of.need("factor", "1")) {
      term->factor = factor->number(quantity::any).value_or(1);
      if (term->factor == 0) factor->error("is 0; leave the joint out");
    }
    c.terms.push_back(*term);
  }
  if (terms->is_list() && terms->list().empty()) terms->error("is empty; it couples nothing");
}

/// Global axes of both sides; nothing where they are those of the frames that are named.
std::optional<std::pair<Eigen::Matrix3d, Eigen::Matrix3d>> read_constraint_axes(const Part& part,
                                                                                const Fields& fields,
                                                                                const ConstraintInfo& info) {
  const auto axis = fields.get("axis"), axis2 = info.axes > 1 ? fields.get("axis2") : std::nullopt;
  if (!axis) {
    if (axis2) axis2->error("goes with 'axis', which is missing");
    return {};
  }
  const auto first = axis->direction();
  const auto second = axis2 ? axis2->direction() : first;
  if (!first || !second) return {};
  if (info.second_axis && !axis2)
    fields.error("'axis2' is missing: the direction on the second that stays at right angles");
  if (const std::string_view fault = info.axes_fault ? info.axes_fault(*first, *second) : "";
      !fault.empty()) {
    axis->error(std::string(fault));
    return {};
  }
  return constraint_axes(info, part.place.vector(*first), part.place.vector(*second));
}

/// The frames of both sides; false where something is wrong, and said.
bool read_sides(Builder& builder, const Part& part, const Fields& fields, const ConstraintInfo& info,
                spec::Constraint& c) {
  const auto between = fields.need("between", "[arm, rod]");
  if (!between) return false;
  const auto pair = between->list();
  if (pair.size() != 2) {
    if (between->is_list()) between->error("two bodies or frames are needed, for example [arm, rod]");
    return false;
  }
  const std::optional<Attachment> sides[2] = {resolve_attachment(builder, part, pair[0]),
                                              resolve_attachment(builder, part, pair[1])};
  if (!sides[0] || !sides[1]) return false;
  // One place that both have, or of a distance two.
  std::optional<Eigen::Vector3d> place[2];
  if (const auto at = fields.get("at")) {
    const auto point = [&](const Value& given) -> std::optional<Eigen::Vector3d> {
      const auto triple = given.triple(quantity::length);
      return triple ? std::optional(part.place.point(*triple)) : std::nullopt;
    };
    if (!info.two_places) {
      place[0] = place[1] = point(*at);
      if (!place[0]) return false;
    } else {
      const auto list = at->list();
      if (list.size() != 2) {
        if (at->is_list()) at->error("two places are needed: [[x, y, z], [x, y, z]]");
        return false;
      }
      for (int k = 0; k < 2; ++k)
        if (!list[static_cast<std::size_t>(k)].is_null()) place[k] = point(list[static_cast<std::size_t>(k)]);
    }
  }
  const bool with_axes = info.axes > 0;
  const auto axes = with_axes ? read_constraint_axes(part, fields, info) : std::nullopt;
  if (fields.value().tree().find("axis") && with_axes && !axes) return false;
  for (int k = 0; k < 2; ++k)
    if (sides[k]->frame >= 0) place[k] = builder.global_pose(sides[k]->frame).position;
  for (int k = 0; k < 2; ++k)
    if (!place[k] && !info.two_places) place[k] = place[1 - k];
  // Axes that both frames have where no directions are given.
  std::optional<Eigen::Matrix3d> common;
  if (info.aligned) common = Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  for (const auto& side : sides)
    if (common && side->frame >= 0) common = builder.global_pose(side->frame).rotation;
  int frames[2];
  for (int k = 0; k < 2; ++k) {
    const Attachment& side = *sides[k];
    const Value& named = pair[static_cast<std::size_t>(k)];
    if (side.frame >= 0 && !axes) {
      frames[k] = side.frame;
      continue;
    }
    if (with_axes && !axes) {
      fields.error(
          fmt::format("'axis' is missing; a {} constraint between bodies needs it, for example axis: "
                      "[0, 0, 1]",
                      info.name));
      return false;
    }
    if (!place[k] && info.force && (side.body == spec::ground || !info.two_places)) {
      fields.error(side.body == spec::ground && info.two_places
                       ? "a point of the ground needs its place: at: [[x, y, z], null]"
                       : "'at' is missing; where two bodies are named the constraint needs its place, for "
                         "example at: [0, 0, 0]");
      return false;
    }
    const spec::Pose body = builder.body_pose(side.body);
    const std::string name = c.name + (k == 0 ? ".a" : ".b");
    frames[k] = builder.add_frame_at(
        name, side.body, place[k].value_or(body.position),
        axes ? (k == 0 ? axes->first : axes->second) : common.value_or(body.rotation), named);
    builder.claim_end(builder.constraint_names, part, c.name, k == 0 ? 'a' : 'b', named.mark(), frames[k]);
  }
  c.frame_a = frames[0];
  c.frame_b = frames[1];
  return true;
}

/// The hollow of a grid that is narrowest, where a wheel of that radius does not fit into it; empty: it fits
/// everywhere. Second differences of the heights are the road's second derivatives at its points.
std::string hollow_of(const spec::Road& road, double radius) {
  const Eigen::MatrixXd& z = road.heights;
  double most = 0;
  Eigen::Index row = 0, column = 0;
  for (Eigen::Index j = 1; j + 1 < z.rows(); ++j)
    for (Eigen::Index i = 1; i + 1 < z.cols(); ++i) {
      const double xx = (z(j, i + 1) - 2 * z(j, i) + z(j, i - 1)) / (road.spacing[0] * road.spacing[0]),
                   yy = (z(j + 1, i) - 2 * z(j, i) + z(j - 1, i)) / (road.spacing[1] * road.spacing[1]),
                   xy = (z(j + 1, i + 1) - z(j + 1, i - 1) - z(j - 1, i + 1) + z(j - 1, i - 1)) /
                        (4 * road.spacing[0] * road.spacing[1]);
      const double half = 0.5 * (xx - yy), up = 0.5 * (xx + yy) + std::sqrt(half * half + xy * xy);
      if (up <= most) continue;
      most = up;
      row = j;
      column = i;
    }
  if (!(most * radius > 1)) return "";
  return fmt::format(
      "a wheel with a radius of {:.6g} m does not fit into the hollow of road '{}' at x = {:.6g}, y = {:.6g} "
      "m, whose "
      "radius is {:.3g} m: it would touch the road at two points, and the run may fail there; smooth the "
      "road, or take "
      "a tyre",
      radius, road.name, road.origin[0] + static_cast<double>(column) * road.spacing[0],
      road.origin[1] + static_cast<double>(row) * road.spacing[1], 1 / most);
}

/// Of what rolls on a road: the frame of the wheel, with its axis as z, and one of the ground.
void read_on_road(Builder& builder, const Part& part, const Value& value, const ConstraintInfo& info,
                  spec::Constraint& c) {
  std::vector<std::string> keys{"type", "on", "at", "axis", "road"};
  for (const LawNumber& number : info.numbers) keys.emplace_back(number.key);
  const Fields fields(value, keys);
  if (const auto road = fields.need("road", "track"))
    if (const auto name = road->word()) c.road = builder.resolve(builder.road_names, part, *name, *road);
  c.numbers = read_numbers(info.numbers, fields, value, false, false);
  const auto on = fields.need("on", "wheel");
  const auto side = on ? resolve_attachment(builder, part, *on) : std::nullopt;
  const auto at = fields.get("at"), axis = fields.get("axis");
  const auto triple = at ? at->triple(quantity::length) : std::nullopt;
  const auto direction = axis ? axis->direction() : std::nullopt;
  if (!side || (at && !triple) || (axis && !direction)) return;
  if (at && side->frame >= 0) return at->error("goes with the name of a body; a frame has its place already");
  if (side->frame >= 0 && !axis) {
    c.frame_b = side->frame;
  } else {
    if (!axis) return fields.error("'axis' is missing: that of the wheel, for example axis: [0, 1, 0]");
    if (side->frame < 0 && !at)
      return fields.error("'at' is missing: the place of the wheel's centre, for example at: [0, 0, 0.3]");
    const Eigen::Vector3d place =
        side->frame >= 0 ? builder.global_pose(side->frame).position : part.place.point(*triple);
    c.frame_b = builder.add_frame_at(
        c.name + ".b", side->body, place,
        constraint_axes(info, part.place.vector(*direction), part.place.vector(*direction)).second, *on);
    builder.claim_end(builder.constraint_names, part, c.name, 'b', on->mark(), c.frame_b);
  }
  c.frame_a = builder.add_frame_at(c.name + ".a", spec::ground, Eigen::Vector3d::Zero(),
                                   Eigen::Matrix3d::Identity(), *on);
  builder.claim_end(builder.constraint_names, part, c.name, 'a', on->mark(), c.frame_a);
  ConstraintInfo::Faults faults;
  if (c.numbers[0] > 0) info.check(c, faults);
  for (const std::string& fault : faults) fields.error(fault);
  if (c.road >= 0 && c.numbers[0] > 0)
    if (const std::string hollow =
            hollow_of(builder.model.roads[static_cast<std::size_t>(c.road)], c.numbers[0]);
        !hollow.empty())
      builder.warnings.push_back({value.mark(), fmt::format("constraint '{}': {}", c.name, hollow)});
}

void read_between(Builder& builder, const Part& part, const Value& value, const ConstraintInfo& info,
                  spec::Constraint& c) {
  std::vector<std::string> keys{"type", "between", "at"};
  if (info.axes > 0) keys.emplace_back("axis");
  if (info.axes > 1) keys.emplace_back("axis2");
  for (const LawNumber& number : info.numbers) keys.emplace_back(number.key);
  if (info.curve) keys.insert(keys.end(), {"points", "closed"});
  const Fields fields(value, keys);
  const bool sides = read_sides(builder, part, fields, info, c);
  c.numbers = read_numbers(info.numbers, fields, value, false, info.complete != nullptr);
  for (std::size_t k = 0; k < c.numbers.size(); ++k)
    if ((info.handed >> k & 1u) != 0) c.numbers[k] *= part.place.determinant();
  const auto points =
      info.curve ? fields.need("points", "[[0, 0, 0], [1, 0, 0.2], [2, 0, 0]]") : std::nullopt;
  const bool all_numbers =
      std::all_of(info.numbers.begin(), info.numbers.end(), [&](const LawNumber& number) {
        return info.complete || !std::isnan(number.otherwise) || fields.has(std::string(number.key));
      });
  if (!sides || !all_numbers || (info.curve && !(points && points->is_list()))) return;
  const spec::Pose a = builder.global_pose(c.frame_a), b = builder.global_pose(c.frame_b);
  if (info.complete) info.complete(a.position, b.position, c.numbers);
  if (points)
    for (const Value& point : points->list())
      if (const auto p = point.triple(quantity::length))
        c.points.push_back(a.rotation.transpose() * (part.place.point(*p) - a.position));
  if (const auto closed = info.curve ? fields.get("closed") : std::nullopt)
    c.closed = closed->flag().value_or(false);
  ConstraintInfo::Faults faults;
  if (info.check) info.check(c, faults);
  for (const std::string& fault : faults) fields.error(fault);
}

void read_constraint(Builder& builder, const Part& part, const Value& value, spec::Constraint& c) {
  if (!value.has_fields()) return value.error("a description is needed, for example {type: gear, …}");
  std::vector<std::string> types;
  for (const ConstraintInfo* info : all_constraints()) types.emplace_back(info->name);
  const std::size_t kinds = types.size();
  types.insert(types.end(), uses.begin(), uses.end());
  const Tree::Entry* entry = value.is_map() ? value.tree().find("type") : nullptr;
  if (!entry) return value.error(fmt::format("'type' is missing; it is one of: {}", joined(types)));
  const auto choice = Value(value.reading(), *entry->value, value.what() + ": type").choice(types);
  if (!choice) return;
  const auto type = static_cast<std::size_t>(*choice);
  if (type < kinds) c.type = types[type];
  const ConstraintInfo& info = constraint_info(find_constraint(c.type));
  if (info.on_road) return read_on_road(builder, part, value, info, c);
  if (!info.of_coordinates) return read_between(builder, part, value, info, c);
  constexpr std::array readers{read_gear, read_rack, read_differential};
  if (type < kinds)
    read_coupling(builder, part, value, c);
  else
    readers[type - kinds](builder, part, value, c);
  c.numbers = {0};
  if (const Tree::Entry* constant = value.tree().find("constant"))
    c.numbers = {Value(value.reading(), *constant->value, value.what() + ": constant")
                     .number(quantity::any)
                     .value_or(0)};
}

}  // namespace

void read_constraints(Builder& builder, Part& part) {
  read_each(builder, part, "constraints", builder.constraint_names, builder.model.constraints,
            read_constraint);
}

}  // namespace mimbre::model_file
