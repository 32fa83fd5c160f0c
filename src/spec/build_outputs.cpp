#include <algorithm>
#include <limits>

#include "joints/joint_kind.h"
#include "math/stress.h"
#include "mimbre/reduced_body.h"
#include "spec/model_builder_parts.h"
#include "spec/output_kinds.h"

/// Channels by names: what a model file's `outputs` contain (src/model_file/sections/outputs.cpp).
namespace mimbre {
namespace {

using Measured = spec::Output::Kind;
using Of = OutputKind::Of;
using Words = std::vector<std::string>;

const OutputKind& find_kind(const Addition& addition, const std::string& word) {
  Words words;
  for (const OutputKind& row : output_kinds) {
    if (word == row.key) return row;
    words.emplace_back(row.key);
  }
  addition.refuse(
      fmt::format("kind: '{}' is not one of {}{}", word, listed(words), did_you_mean(word, words)));
}

/// "x", or its number; 0 where there is only one.
int find_component(const Addition& addition, const std::string& given, const Words& words) {
  if (given.empty() && words.size() == 1) return 0;
  if (given.empty()) addition.refuse(fmt::format("'component' is missing; one of {}", listed(words)));
  for (std::size_t k = 0; k < words.size(); ++k)
    if (given == words[k] || given == std::to_string(k)) return static_cast<int>(k);
  addition.refuse(
      fmt::format("component: '{}' is not one of {}{}", given, listed(words), did_you_mean(given, words)));
}

Words numbers(int count) {
  Words words;
  for (int k = 0; k < count; ++k) words.push_back(std::to_string(k));
  return words;
}

const Words axes{"x", "y", "z"};

/// What is given must be used, so that a mistake does not look like a success.
void check_used(const Addition& addition, const OutputKind& kind, const build::Output& given) {
  const bool stress = kind.kind == Measured::stress || kind.kind == Measured::strain;
  const auto only = [&](bool is_given, bool is_used, const char* what, const char* belongs_to) {
    if (is_given && !is_used) addition.refuse(fmt::format("'{}' belongs to {}", what, belongs_to));
  };
  only(given.at.has_value(), kind.of == Of::frame || stress || kind.kind == Measured::section_force, "at",
       "outputs of a body");
  only(given.along.has_value(), kind.kind == Measured::deflection || kind.kind == Measured::strain, "along",
       "'deflection' and 'strain'");
  only(!given.relative_to.empty(), kind.kind == Measured::displacement, "relative_to", "'displacement'");
  only(given.about.has_value(), kind.kind == Measured::angular_momentum, "about", "'angular_momentum'");
  only(given.node.has_value(), stress, "node", "'stress' and 'strain'");
  only(given.offset != 0, kind.kind == Measured::joint_position, "offset", "'joint'");
  only(given.own_axes, kind.kind == Measured::angular_velocity, "own_axes", "'angular_velocity'");
  only(!given.bodies.empty(), kind.of == Of::bodies, "bodies", "outputs of the motion of mass");
  only(!given.on.empty(), kind.of == Of::contact, "on", "outputs of a contact");
  if (!given.component.empty() && !has_component(kind))
    addition.refuse(fmt::format("'{}' has no component", kind.key));
}

void of_frame(Addition& addition, const build::Output& given, const std::string& name, spec::Output& output) {
  output.item = addition.attach("of", given.of, given.at, name + ".output");
  const Measured kind = output.kind;
  if (kind == Measured::deflection) {
    if (!given.along) addition.refuse("'along' is missing; a deflection is along a direction");
    const int body = addition.frame(output.item).body;
    output.direction =
        addition.body_pose(body).rotation.transpose() * addition.direction("along", *given.along);
    return;
  }
  if (kind == Measured::roll || kind == Measured::pitch || kind == Measured::yaw) return;
  output.component = find_component(addition, given.component, axes);
  output.own_axes = given.own_axes;
  if (kind != Measured::displacement) return;
  if (given.relative_to == "ground")
    addition.refuse("the ground has no axes of its own here; name a frame of it, or use 'position'");
  output.reference = addition.attach("relative_to", given.relative_to, {}, name + ".reference");
  const spec::Pose here = addition.frame_pose(output.reference);
  output.direction = Eigen::Vector3d::Unit(output.component);
  output.offset = -output.direction.dot(here.rotation.transpose() *
                                        (addition.frame_pose(output.item).position - here.position));
}

void of_joint(const Addition& addition, const ModelBuilder::Impl& builder, const build::Output& given,
              spec::Output& output) {
  output.item = addition.find(builder.joints, "of", given.of);
  if (output.kind == Measured::joint_force) {
    output.component = find_component(addition, given.component, {"fx", "fy", "fz", "mx", "my", "mz"});
    return;
  }
  const JointInfo& info = joint_info(builder.model.joints[static_cast<std::size_t>(output.item)].type);
  if (output.kind == Measured::joint_rotation || output.kind == Measured::joint_quaternion) {
    if (info.quaternion < 0)
      addition.refuse(fmt::format("a {} joint has coordinates of its own; see kind 'joint'", info.name));
    output.component =
        find_component(addition, given.component,
                       output.kind == Measured::joint_rotation ? axes : Words{"w", "x", "y", "z"});
    return;
  }
  const bool rate = output.kind == Measured::joint_velocity || output.kind == Measured::joint_acceleration;
  const int count = info.quaternion < 0 || rate ? info.velocities : info.quaternion;
  if (count == 0) addition.refuse(fmt::format("a {} joint has no scalar coordinate", info.name));
  output.component = find_component(addition, given.component, numbers(count));
  output.offset = given.offset;
}

/// The node of the body's surface of this number in its mesh, or at this place.
int surface_node(const Addition& addition, const build::Output& given, const spec::Body& body) {
  const ReducedBody& reduced = *body.flexible;
  if (given.node) {
    const auto& labels = reduced.node_labels;
    const auto found = std::find(labels.begin(), labels.end(), *given.node);
    if (found == labels.end()) addition.refuse(fmt::format("the body's surface has no node {}", *given.node));
    return static_cast<int>(found - labels.begin());
  }
  if (!given.at || reduced.nodes.cols() == 0) return -1;
  const Eigen::Vector3d wanted =
      body.pose.rotation.transpose() * (addition.point("at", *given.at) - body.pose.position);
  Eigen::Index nearest = 0;
  const double distance = (reduced.nodes.colwise() - wanted).colwise().norm().minCoeff(&nearest);
  const double size = (reduced.nodes.rowwise().maxCoeff() - reduced.nodes.rowwise().minCoeff()).norm();
  if (distance > 0.02 * size)
    addition.refuse(fmt::format("the nearest node of the body's surface is {:.3g} m away", distance));
  return static_cast<int>(nearest);
}

/// The section nearest to a place; of the two at a node the end of an element.
void of_section(const Addition& addition, const build::Output& given, const spec::Body& body,
                spec::Output& output) {
  output.component =
      find_component(addition, given.component, {section_components.begin(), section_components.end()});
  if (!body.flexible || !body.flexible->sections)
    addition.refuse(
        fmt::format("body '{}' knows no section forces; reduce its bars with `sections`", given.of));
  if (!given.at) addition.refuse("'at' is missing: a place on the axis of a bar");
  const Eigen::Vector3d local =
      body.pose.rotation.transpose() * (addition.point("at", *given.at) - body.pose.position);
  double nearest = std::numeric_limits<double>::infinity();
  const auto& sections = body.flexible->sections->sections;
  for (std::size_t k = 0; k < sections.size(); ++k) {
    const double off = (sections[k].position - local).norm();
    const double alike = 1e-9 * sections[k].position.norm();
    if (off < nearest - alike || (k % 2 == 1 && output.node % 2 == 0 && off < nearest + alike)) {
      nearest = std::min(nearest, off);
      output.node = static_cast<int>(k);
    }
  }
}

void of_body(const Addition& addition, const ModelBuilder::Impl& builder, const build::Output& given,
             spec::Output& output) {
  output.item = addition.find(builder.bodies, "of", given.of);
  const spec::Body& body = builder.model.bodies[static_cast<std::size_t>(output.item)];
  if (output.kind == Measured::modal_amplitude) {
    if (!body.flexible || body.flexible->modes <= 0)
      addition.refuse(fmt::format("body '{}' is rigid and has no modes", given.of));
    if (given.component.empty()) addition.refuse("'component' is missing; for example \"0\"");
    output.component = find_component(addition, given.component, numbers(body.flexible->modes));
    return;
  }
  if (output.kind == Measured::section_force) return of_section(addition, given, body, output);
  Words words(stress_components.begin(), stress_components.end());
  const bool stress = output.kind == Measured::stress;
  if (!stress) words.pop_back();  // von Mises is a measure of stress
  if (given.along) {
    if (!given.component.empty()) addition.refuse("give 'along' or 'component', not both");
    output.direction = body.pose.rotation.transpose() * addition.direction("along", *given.along);
  } else {
    output.component = !given.component.empty() ? find_component(addition, given.component, words)
                       : stress                 ? von_mises_component
                                                : max_principal_component;
  }
  if (given.node && given.at) addition.refuse("give 'node' or 'at', not both");
  if (body.flexible) output.node = surface_node(addition, given, body);
}

void of_bodies(const Addition& addition, const ModelBuilder::Impl& builder, const build::Output& given,
               spec::Output& output) {
  output.component = find_component(addition, given.component, axes);
  Words names = given.bodies;
  if (!given.of.empty() && !names.empty()) addition.refuse("give 'of' or 'bodies', not both");
  if (!given.of.empty()) names = {given.of};
  for (const std::string& name : names)
    output.bodies.push_back(addition.find(builder.bodies, "bodies", name));
  if (given.about) output.about = addition.point("about", *given.about);
}

}  // namespace

void ModelBuilder::add_output(const std::string& name, const build::Output& given) {
  Addition addition(*impl_, impl_->outputs, name);
  addition.coordinates_of(given.in);
  const OutputKind& kind = find_kind(addition, given.kind);
  check_used(addition, kind, given);
  spec::Output output;
  output.name = name;
  output.kind = kind.kind;
  switch (kind.of) {
    case Of::frame:
      of_frame(addition, given, name, output);
      break;
    case Of::joint:
      of_joint(addition, *impl_, given, output);
      break;
    case Of::body:
      of_body(addition, *impl_, given, output);
      break;
    case Of::bodies:
      of_bodies(addition, *impl_, given, output);
      break;
    case Of::spring:
      output.item = addition.find(impl_->springs, "of", given.of);
      break;
    case Of::tyre:
      output.item = addition.find(impl_->tyres, "of", given.of);
      if (kind.kind == Measured::tyre_moment)
        output.component = find_component(addition, given.component,
                                          {tyre_moment_components.begin(), tyre_moment_components.end()});
      if (kind.kind == Measured::tyre_force && !given.component.empty())
        output.component = find_component(addition, given.component,
                                          {tyre_force_components.begin(), tyre_force_components.end()});
      break;
    case Of::contact:
      output.item = addition.find(impl_->contacts, "of", given.of);
      if (kind.kind == Measured::contact_force)
        output.component =
            find_component(addition, given.component, {contact_components.begin(), contact_components.end()});
      if (!given.on.empty()) output.bodies = {addition.find(impl_->bodies, "on", given.on)};
      break;
  }
  addition.commit(impl_->outputs, impl_->model.outputs.size());
  impl_->model.outputs.push_back(std::move(output));
}

}  // namespace mimbre
