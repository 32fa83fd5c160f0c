#include <numbers>

#include "mimbre/diagnostics.h"
#include "spec/constraint_kind.h"
#include "spec/coupling_uses.h"
#include "spec/model_builder_parts.h"

/// Constraints by names: what a model file's `constraints` contain (src/model_file/sections/constraints.cpp).
namespace mimbre {
namespace {

const ConstraintInfo& constraint_of(const Addition& addition, const std::string& type) {
  if (const int kind = find_constraint(type); kind >= 0) return constraint_info(kind);
  std::vector<std::string> known;
  for (const ConstraintInfo* info : all_constraints()) known.emplace_back(info->name);
  addition.refuse(
      fmt::format("type: there is no '{}'{}; there are {}", type, did_you_mean(type, known), listed(known)));
}

/// Axes of both sides, global; nothing where they are those of the frames that are named.
std::optional<std::pair<Eigen::Matrix3d, Eigen::Matrix3d>> given_axes(const Addition& addition,
                                                                      const ConstraintInfo& info,
                                                                      const build::Constraint& given) {
  if (given.axis && info.axes < 1) addition.refuse(fmt::format("{}: has no axis", info.name));
  if (given.axis2 && info.axes < 2) addition.refuse(fmt::format("{}: has no second axis", info.name));
  if (!given.axis) {
    if (given.axis2) addition.refuse("'axis' is missing beside 'axis2'");
    return {};
  }
  const Eigen::Vector3d first = addition.direction("axis", *given.axis);
  if (info.second_axis && !given.axis2)
    addition.refuse("'axis2' is missing: the direction on the second that stays at right angles");
  const Eigen::Vector3d second = given.axis2 ? addition.direction("axis2", *given.axis2) : first;
  if (info.axes_fault)
    if (const auto fault = info.axes_fault(first, second); !fault.empty())
      addition.refuse(std::string(fault));
  return constraint_axes(info, first, second);
}

void make_sides(Addition& addition, const std::string& name, const ConstraintInfo& info,
                const build::Constraint& given, spec::Constraint& made) {
  if (!given.terms.empty()) addition.refuse("only a coupling has terms");
  const Attachment sides[2] = {addition.attachment("between", given.between[0]),
                               addition.attachment("between", given.between[1])};
  const auto axes = given_axes(addition, info, given);
  // Where they meet: the place that is given, or that of the frame that is named.
  std::optional<Eigen::Vector3d> place[2];
  for (int k = 0; k < 2; ++k) {
    if (sides[k].frame >= 0) {
      if (given.at[k]) addition.refuse("a frame has its place already; 'at' goes with the name of a body");
      place[k] = addition.frame_pose(sides[k].frame).position;
    } else if (given.at[k]) {
      place[k] = addition.point("at", *given.at[k]);
    }
  }
  if (info.on_road) {
    if (!place[1]) addition.refuse("the wheel's centre needs its place, 'at' of the second");
    if (!place[0]) place[0] = Eigen::Vector3d::Zero();
  }
  if (!info.two_places)
    for (int k = 0; k < 2; ++k)
      if (!place[k]) place[k] = place[1 - k];
  // Axes that both frames have where no directions are given.
  std::optional<Eigen::Matrix3d> common;
  if (info.aligned) common = Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  for (const Attachment& side : sides)
    if (common && side.frame >= 0) common = addition.frame_pose(side.frame).rotation;
  int frames[2];
  for (int k = 0; k < 2; ++k) {
    const bool own_axes = axes || info.axes == 0 || (info.on_road && k == 0);
    if (sides[k].frame < 0 && !own_axes)
      addition.refuse(fmt::format("'axis' is missing: '{}' is a body, which has no direction of its own",
                                  given.between[static_cast<std::size_t>(k)]));
    if (!place[k] && sides[k].body == spec::ground && info.two_places)
      addition.refuse("a point of the ground needs its place, 'at'");
    if (sides[k].frame >= 0 && !axes) {
      frames[k] = sides[k].frame;
    } else if (sides[k].frame < 0 && !axes && !common && !place[k] && sides[k].body != spec::ground) {
      frames[k] = addition.own_frame(sides[k].body);
    } else {
      const spec::Pose body = addition.body_pose(sides[k].body);
      frames[k] =
          addition.new_frame(name + (k == 0 ? ".a" : ".b"), sides[k].body,
                             {place[k].value_or(body.position),
                              axes ? (k == 0 ? axes->first : axes->second) : common.value_or(body.rotation)});
    }
  }
  made.frame_a = frames[0];
  made.frame_b = frames[1];
  const spec::Pose a = addition.frame_pose(made.frame_a), b = addition.frame_pose(made.frame_b);
  if (info.complete) info.complete(a.position, b.position, made.numbers);
  for (const Eigen::Vector3d& p : given.points)
    made.points.push_back(a.rotation.transpose() * (addition.point("points", p) - a.position));
  made.closed = given.closed;
}

}  // namespace

namespace build {

Constraint gear(const std::string& first, const std::string& second, double ratio) {
  const auto factor = gear_factors(ratio);
  return {.terms = {{first, factor[0]}, {second, factor[1]}}};
}
Constraint rack(const std::string& pinion, const std::string& rack, double travel) {
  const auto factor = rack_factors(travel / (2 * std::numbers::pi));
  return {.terms = {{pinion, factor[0]}, {rack, factor[1]}}};
}
Constraint differential(const std::string& cage, const std::string& left, const std::string& right) {
  const auto& factor = differential_factors;
  return {.terms = {{cage, factor[0]}, {left, factor[1]}, {right, factor[2]}}};
}

}  // namespace build

void ModelBuilder::add_constraint(const std::string& name, const build::Constraint& given) {
  Addition addition(*impl_, impl_->constraints, name);
  addition.coordinates_of(given.in);
  spec::Constraint made;
  made.name = name;
  made.type = given.type;
  const ConstraintInfo& info = constraint_of(addition, given.type);
  made.numbers = numbers_by_key(addition, info.name, info.numbers, given.numbers);
  // Others follow from the assembled position.
  if (!info.complete) require_numbers(addition, info.numbers, made.numbers);
  if (info.of_coordinates) {
    for (const build::Constraint::Term& term : given.terms)
      made.terms.push_back({addition.find(impl_->joints, "terms", term.joint), term.coordinate, term.factor});
  } else {
    make_sides(addition, name, info, given, made);
  }
  if (info.on_road && given.road.empty()) addition.refuse("'road' is missing: the name of one over a grid");
  if (!given.road.empty()) made.road = addition.find(impl_->roads, "road", given.road);
  addition.commit(impl_->constraints, impl_->model.constraints.size());
  impl_->model.constraints.push_back(std::move(made));
}

}  // namespace mimbre
