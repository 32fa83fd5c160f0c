#include <numbers>

#include "spec/constraint_axes.h"
#include "spec/constraint_kinds.h"
#include "spec/model_builder_parts.h"

/// Constraints by names: what a model file's `constraints` contain (src/model_file/sections/constraints.cpp).
namespace mimbre {
namespace {

using ConstraintKind = spec::Constraint::Kind;

/// Axes of both sides, global; nothing where they are those of the frames that are named.
std::optional<std::pair<Eigen::Matrix3d, Eigen::Matrix3d>> given_axes(const Addition& addition,
                                                                      const build::Constraint& given) {
  const auto name = constraint_info(given.kind).name;
  if (given.axis && !has_axis(given.kind)) addition.refuse(fmt::format("{}: has no axis", name));
  if (given.axis2 && !has_second_axis(given.kind))
    addition.refuse(fmt::format("{}: has no second axis", name));
  if (!given.axis) {
    if (given.axis2) addition.refuse("'axis' is missing beside 'axis2'");
    return {};
  }
  const Eigen::Vector3d first = addition.direction("axis", *given.axis);
  if (given.kind == ConstraintKind::perpendicular && !given.axis2)
    addition.refuse("'axis2' is missing: the direction on the second that stays at right angles");
  const Eigen::Vector3d second = given.axis2 ? addition.direction("axis2", *given.axis2) : first;
  if (given.kind == ConstraintKind::constant_velocity && !(first.dot(second) > -1 + 1e-9))
    addition.refuse("the shafts point against each other; turn one of the axes round");
  return constraint_axes(given.kind, first, second);
}

void make_sides(Addition& addition, const std::string& name, const build::Constraint& given,
                spec::Constraint& made) {
  if (!given.terms.empty()) addition.refuse("only a coupling has terms");
  const Attachment sides[2] = {addition.attachment("between", given.between[0]),
                               addition.attachment("between", given.between[1])};
  const auto axes = given_axes(addition, given);
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
  if (given.kind != ConstraintKind::distance)
    for (int k = 0; k < 2; ++k)
      if (!place[k]) place[k] = place[1 - k];
  int frames[2];
  for (int k = 0; k < 2; ++k) {
    const bool own_axes = axes || !has_axis(given.kind);
    if (sides[k].frame < 0 && !own_axes)
      addition.refuse(fmt::format("'axis' is missing: '{}' is a body, which has no direction of its own",
                                  given.between[static_cast<std::size_t>(k)]));
    if (!place[k] && sides[k].body == spec::ground && given.kind == ConstraintKind::distance)
      addition.refuse("a point of the ground needs its place, 'at'");
    if (sides[k].frame >= 0 && !axes) {
      frames[k] = sides[k].frame;
    } else if (sides[k].frame < 0 && !axes && !place[k] && sides[k].body != spec::ground) {
      frames[k] = addition.own_frame(sides[k].body);
    } else {
      const spec::Pose body = addition.body_pose(sides[k].body);
      frames[k] = addition.new_frame(
          name + (k == 0 ? ".a" : ".b"), sides[k].body,
          {place[k].value_or(body.position), axes ? (k == 0 ? axes->first : axes->second) : body.rotation});
    }
  }
  made.frame_a = frames[0];
  made.frame_b = frames[1];
  const spec::Pose a = addition.frame_pose(made.frame_a), b = addition.frame_pose(made.frame_b);
  made.length = given.length.value_or((b.position - a.position).norm());
  made.lead = given.lead;
  for (const Eigen::Vector3d& p : given.points)
    made.points.push_back(a.rotation.transpose() * (addition.point("points", p) - a.position));
  made.closed = given.closed;
}

}  // namespace

namespace build {

Constraint gear(const std::string& first, const std::string& second, double ratio) {
  return {.terms = {{first, 1}, {second, -ratio}}};
}
Constraint rack(const std::string& pinion, const std::string& rack, double travel) {
  return {.terms = {{rack, 1}, {pinion, -travel / (2 * std::numbers::pi)}}};
}
Constraint differential(const std::string& cage, const std::string& left, const std::string& right) {
  return {.terms = {{left, 1}, {right, 1}, {cage, -2}}};
}

}  // namespace build

void ModelBuilder::add_constraint(const std::string& name, const build::Constraint& given) {
  Addition addition(*impl_, impl_->constraints, name);
  addition.coordinates_of(given.in);
  spec::Constraint made;
  made.name = name;
  made.kind = given.kind;
  if (given.kind == ConstraintKind::coupling) {
    for (const build::Constraint::Term& term : given.terms)
      made.terms.push_back({addition.find(impl_->joints, "terms", term.joint), term.coordinate, term.factor});
    made.constant = given.constant;
  } else {
    make_sides(addition, name, given, made);
  }
  addition.commit(impl_->constraints, impl_->model.constraints.size());
  impl_->model.constraints.push_back(std::move(made));
}

}  // namespace mimbre
