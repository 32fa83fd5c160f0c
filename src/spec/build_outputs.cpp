#include <algorithm>
#include <limits>

#include "joints/joint_kind.h"
#include "mimbre/reduced_body.h"
#include "spec/model_builder_parts.h"
#include "spec/output_words.h"

/// Channels by names: what a model file's `outputs` contain (src/model_file/sections/outputs.cpp).
namespace mimbre {
namespace {

using Of = OutputInfo::Of;
using Place = OutputInfo::Place;
using Words = std::vector<std::string>;

const OutputInfo& find_kind(const Addition& addition, const std::string& word) {
  Words words;
  for (const OutputInfo* info : all_outputs()) {
    if (!info->in_files) continue;
    if (word == info->name) return *info;
    words.emplace_back(info->name);
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

Words words_of(const OutputInfo& info) { return {info.words.begin(), info.words.end()}; }

void check_used(const Addition& addition, const OutputInfo& kind, const build::Output& given) {
  const std::pair<const char*, bool> keys[] = {{"component", !given.component.empty()},
                                               {"at", given.at.has_value()},
                                               {"on", !given.on.empty()},
                                               {"bodies", !given.bodies.empty()},
                                               {"along", given.along.has_value()},
                                               {"relative_to", !given.relative_to.empty()},
                                               {"about", given.about.has_value()},
                                               {"node", given.node.has_value()},
                                               {"offset", given.offset != 0},
                                               {"axes", given.own_axes}};
  const auto faults = unused_keys(kind, [&](const std::string& key) {
    return std::any_of(std::begin(keys), std::end(keys),
                       [&](const auto& one) { return one.second && one.first == key; });
  });
  if (!faults.empty()) addition.refuse(faults.front());
}

void read_words(const Addition& addition, const OutputInfo& kind, const build::Output& given,
                spec::Output& output) {
  if (given.component.empty() && kind.otherwise >= 0)
    output.component = kind.otherwise;
  else
    output.component = find_component(addition, given.component, words_of(kind));
}

void of_frame(Addition& addition, const OutputInfo& kind, const build::Output& given, spec::Output& output) {
  output.item = addition.attach("of", given.of, given.at, output.name + ".output");
  if (kind.along) {
    if (!given.along) addition.refuse("'along' is missing; a deflection is along a direction");
    const int body = addition.frame(output.item).body;
    output.direction =
        addition.body_pose(body).rotation.transpose() * addition.direction("along", *given.along);
  }
  if (!kind.words.empty()) read_words(addition, kind, given, output);
  output.own_axes = given.own_axes;
  if (!kind.reference) return;
  if (given.relative_to == "ground")
    addition.refuse("the ground has no axes of its own here; name a frame of it, or use 'position'");
  output.reference = addition.attach("relative_to", given.relative_to, {}, output.name + ".reference");
  see_from(output, addition.frame_pose(output.reference), addition.frame_pose(output.item).position);
}

void of_joint(const Addition& addition, const ModelBuilder::Impl& builder, const OutputInfo& kind,
              const build::Output& given, spec::Output& output) {
  output.item = addition.find(builder.joints, "of", given.of);
  const JointInfo& info = joint_info(builder.model.joints[static_cast<std::size_t>(output.item)].type);
  const int count = kind.count ? kind.count(info) : 0;
  if (kind.count && count == 0) addition.refuse(fmt::format("a {} joint {}", info.name, kind.without));
  if (!kind.words.empty()) return read_words(addition, kind, given, output);
  output.component = find_component(addition, given.component, numbers(count));
  output.offset = given.offset;
}

/// The node of the body's surface of this number in its mesh, or at this place; −1: its extreme.
int surface_node_of(const Addition& addition, const build::Output& given, const spec::Body& body) {
  const ReducedBody& reduced = *body.flexible;
  if (!given.node && (!given.at || reduced.nodes.cols() == 0)) return -1;
  const SurfaceNode found = given.node ? surface_node(reduced, *given.node)
                                       : surface_node(reduced, body.pose, addition.point("at", *given.at));
  if (!found.fault.empty()) addition.refuse(found.fault);
  return found.node;
}

/// The section nearest to a place; of the two at a node the end of an element.
void at_section(const Addition& addition, const build::Output& given, const spec::Body& body,
                spec::Output& output) {
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

void of_body(const Addition& addition, const ModelBuilder::Impl& builder, const OutputInfo& kind,
             const build::Output& given, spec::Output& output) {
  output.item = addition.find(builder.bodies, "of", given.of);
  const spec::Body& body = builder.model.bodies[static_cast<std::size_t>(output.item)];
  if (kind.modes) {
    if (!body.flexible || body.flexible->modes <= 0)
      addition.refuse(fmt::format("body '{}' is rigid and has no modes", given.of));
    if (given.component.empty()) addition.refuse("'component' is missing; for example \"0\"");
    output.component = find_component(addition, given.component, numbers(body.flexible->modes));
  } else if (given.along) {
    if (!given.component.empty()) addition.refuse("give 'along' or 'component', not both");
    output.direction = body.pose.rotation.transpose() * addition.direction("along", *given.along);
  } else {
    read_words(addition, kind, given, output);
  }
  if (kind.place == Place::section) return at_section(addition, given, body, output);
  if (given.node && given.at) addition.refuse("give 'node' or 'at', not both");
  if (kind.place == Place::surface && body.flexible) output.node = surface_node_of(addition, given, body);
}

void of_bodies(const Addition& addition, const ModelBuilder::Impl& builder, const OutputInfo& kind,
               const build::Output& given, spec::Output& output) {
  output.component = find_component(addition, given.component, words_of(kind));
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
  const OutputInfo& kind = find_kind(addition, given.kind);
  check_used(addition, kind, given);
  spec::Output output;
  output.name = name;
  output.kind = kind.name;
  switch (kind.of) {
    case Of::frame:
      of_frame(addition, kind, given, output);
      break;
    case Of::joint:
      of_joint(addition, *impl_, kind, given, output);
      break;
    case Of::body:
      of_body(addition, *impl_, kind, given, output);
      break;
    case Of::bodies:
      of_bodies(addition, *impl_, kind, given, output);
      break;
    case Of::spring:
      output.item = addition.find(impl_->springs, "of", given.of);
      break;
    case Of::tyre:
      output.item = addition.find(impl_->tyres, "of", given.of);
      if (!kind.words.empty()) read_words(addition, kind, given, output);
      break;
    case Of::contact:
      output.item = addition.find(impl_->contacts, "of", given.of);
      if (!kind.words.empty()) read_words(addition, kind, given, output);
      if (!given.on.empty()) output.bodies = {addition.find(impl_->bodies, "on", given.on)};
      break;
    case Of::element:
    case Of::signal:
    case Of::input:
      break;  // no kinds of model files
  }
  addition.commit(impl_->outputs, impl_->model.outputs.size());
  impl_->model.outputs.push_back(std::move(output));
}

}  // namespace mimbre
