#include "joints/axes.h"
#include "joints/joint_kind.h"
#include "math/turn.h"
#include "spec/model_builder_parts.h"

/// Joints by names: what a model file's `joints` contain (src/model_file/sections/joints.cpp).
namespace mimbre {
namespace {

using spec::JointType;

/// Joint axes by the given ones, global; nothing where none are given.
std::optional<Eigen::Matrix3d> given_axes(const Addition& addition, const JointInfo& info,
                                          const std::optional<Eigen::Vector3d>& given,
                                          const std::optional<Eigen::Vector3d>& given2) {
  if (given2 && info.axes() < 2) addition.refuse(fmt::format("a {} joint has no second axis", info.name));
  if (!given) return {};
  if (info.axes() < 1) addition.refuse(fmt::format("a {} joint has no axis", info.name));
  const Eigen::Vector3d axis = addition.direction("axis", *given);
  if (info.axes() < 2) return joint_axes(info, axis);
  if (!given2) addition.refuse(fmt::format("'axis2' is missing; a {} joint needs it", info.name));
  const Eigen::Vector3d second = addition.direction("axis2", *given2);
  if (!perpendicular(axis, second)) addition.refuse("axis and axis2 are not perpendicular");
  return joint_axes(info, axis, second);
}

/// Where the joint is, and the frames of both sides there.
std::pair<int, int> make_sides(Addition& addition, const std::string& name, const build::Joint& joint) {
  const Attachment a = addition.attachment("between", joint.between[0]);
  const Attachment b = addition.attachment("between", joint.between[1]);
  if (a.body == b.body)
    addition.refuse(a.body == spec::ground
                        ? "both sides are the ground; a joint needs a body"
                        : fmt::format("both sides, '{}' and '{}', are on one body; a joint needs two bodies",
                                      joint.between[0], joint.between[1]));
  const int frame = a.frame >= 0 ? a.frame : b.frame;
  if (joint.at && frame >= 0)
    addition.refuse("a frame has its place already; 'at' goes with the names of two bodies");
  const JointInfo& info = joint_info(joint.type);
  if (!joint.at && frame < 0 && !info.any_place)
    addition.refuse("'at' is missing; where two bodies are named the joint needs its place");

  std::optional<Eigen::Matrix3d> axes = given_axes(addition, info, joint.axis, joint.axis2);
  if (!axes && frame < 0) {
    if (info.axes() > 0) addition.refuse(fmt::format("'axis' is missing; a {} joint needs it", info.name));
    axes = info.free() ? addition.body_pose(b.body).rotation : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  }
  const Eigen::Vector3d place = joint.at     ? addition.point("at", *joint.at)
                                : frame >= 0 ? addition.frame_pose(frame).position
                                             : addition.body_pose(b.body).position;
  if (joint.at_b) {
    if (!joint.at) addition.refuse("'at' is missing; 'at_b' goes with a point of the first body");
    const std::optional<Eigen::Matrix3d> other =
        joint.axis_b || joint.axis2_b ? given_axes(addition, info, joint.axis_b ? joint.axis_b : joint.axis,
                                                   joint.axis2_b ? joint.axis2_b : joint.axis2)
                                      : axes;
    const int first = addition.new_frame(name + ".a", a.body, {place, *axes});
    return {first, addition.new_frame(name + ".b", b.body, {addition.point("at_b", *joint.at_b), *other})};
  }
  if (joint.axis_b || joint.axis2_b) addition.refuse("'at_b' is missing; 'axis_b' and 'axis2_b' go with it");
  const auto side = [&](const Attachment& attachment, const char* letter) {
    if (attachment.frame >= 0 && !axes) return attachment.frame;
    const spec::Pose there = attachment.frame >= 0 ? addition.frame_pose(attachment.frame)
                             : frame >= 0          ? addition.frame_pose(frame)
                                                   : spec::Pose{place, Eigen::Matrix3d::Identity()};
    return addition.new_frame(name + "." + letter, attachment.body,
                              {there.position, axes.value_or(there.rotation)});
  };
  // What floats from nowhere in particular is the body's own frame, which moves with the tangent frame of a
  // flexible body.
  const bool own_b = info.free() && !joint.at && frame < 0 && b.body != spec::ground;
  const int side_a = side(a, "a");
  return {side_a, own_b ? addition.own_frame(b.body) : side(b, "b")};
}

std::optional<Eigen::Vector3d> three(const std::vector<std::optional<double>>& values, std::size_t first) {
  if (values.size() < first + 3 || !values[first] || !values[first + 1] || !values[first + 2]) return {};
  return Eigen::Vector3d(*values[first], *values[first + 1], *values[first + 2]);
}

/// A floating joint's velocities are given in outer axes; the joint wants a's axes and b's axes.
void turn_velocity(const Addition& addition, spec::Joint& joint) {
  auto& velocity = joint.initial_velocity;
  if (!joint_info(joint.type).free() || velocity.size() != 6) return;
  const auto put = [&](const Eigen::Vector3d& v, std::size_t first) {
    for (std::size_t k = 0; k < 3; ++k) velocity[first + k] = v[static_cast<Eigen::Index>(k)];
  };
  const auto linear = three(velocity, 0), angular = three(velocity, 3);
  const auto any = [&](std::size_t first) {
    return velocity[first] || velocity[first + 1] || velocity[first + 2];
  };
  if ((!linear && any(0)) || (!angular && any(3)))
    addition.refuse(
        "give all three components of a floating joint's linear velocity, and of its angular velocity, or "
        "none");
  const Eigen::Matrix3d a = addition.frame_pose(joint.frame_a).rotation;
  if (linear) put(a.transpose() * addition.vector(*linear), 0);
  if (angular) {
    const Eigen::Vector3d turn = three(joint.initial_position, 3).value_or(Eigen::Vector3d::Zero());
    const Eigen::Matrix3d b = a * turn_by(turn);
    put(b.transpose() * addition.vector(*angular), 3);
  }
}

}  // namespace

void ModelBuilder::add_joint(const std::string& name, const build::Joint& given) {
  Addition addition(*impl_, impl_->joints, name);
  if (!is_joint(given.type))
    addition.refuse(fmt::format("type is {}, which is none of the types", static_cast<int>(given.type)));
  addition.coordinates_of(given.in);
  spec::Joint joint;
  joint.name = name;
  joint.type = given.type;
  joint.cut = given.cut;
  joint.drives = given.drives;
  joint.springs = given.springs;
  joint.initial_position = given.position;
  joint.initial_velocity = given.velocity;
  joint.near = given.near;
  joint.apart = given.at_b.has_value();
  std::tie(joint.frame_a, joint.frame_b) = make_sides(addition, name, given);
  turn_velocity(addition, joint);
  addition.commit(impl_->joints, impl_->model.joints.size());
  impl_->model.joints.push_back(std::move(joint));
}

}  // namespace mimbre
