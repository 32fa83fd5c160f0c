#include "spec/output_words.h"

#include <fmt/format.h>

#include <algorithm>

#include "mimbre/reduced_body.h"

namespace mimbre {
namespace {

using Of = OutputInfo::Of;
using Place = OutputInfo::Place;

/// A key of outputs beside that of the kind, and which kinds take it. `of`: what these are; empty: they are
/// listed.
struct OutputKey {
  const char* key;
  bool (*belongs)(const OutputInfo&);
  const char* of = "";
};
constexpr OutputKey output_keys[] = {
    {"at", [](const OutputInfo& i) { return i.of == Of::frame || i.place != Place::none; },
     "outputs of a body"},
    {"on", [](const OutputInfo& i) { return i.of == Of::contact; }, "outputs of a contact"},
    {"bodies", [](const OutputInfo& i) { return i.of == Of::bodies; }, "outputs of the motion of mass"},
    {"along", [](const OutputInfo& i) { return i.along; }},
    {"relative_to", [](const OutputInfo& i) { return i.reference; }},
    {"about", [](const OutputInfo& i) { return i.about; }},
    {"node", [](const OutputInfo& i) { return i.place == Place::surface; }},
    {"offset", [](const OutputInfo& i) { return i.offset; }},
    {"axes", [](const OutputInfo& i) { return i.own_axes; }},
};

std::string kinds_with(bool (*belongs)(const OutputInfo&)) {
  std::string text;
  for (const OutputInfo* info : all_outputs())
    if (info->in_files && belongs(*info))
      text += fmt::format("{}'{}'", text.empty() ? "" : " and ", info->name);
  return text;
}

}  // namespace

std::vector<std::string> unused_keys(const OutputInfo& kind,
                                     const std::function<bool(const std::string& key)>& given) {
  std::vector<std::string> faults;
  if (!kind.has_component() && given("component"))
    faults.push_back(fmt::format("'{}' has no component", kind.name));
  for (const OutputKey& key : output_keys)
    if (!key.belongs(kind) && given(key.key))
      faults.push_back(fmt::format("'{}' belongs to {}", key.key,
                                   *key.of ? std::string(key.of) : kinds_with(key.belongs)));
  return faults;
}

void see_from(spec::Output& output, const spec::Pose& reference, const Eigen::Vector3d& place) {
  output.direction = Eigen::Vector3d::Unit(output.component);
  output.offset = -output.direction.dot(reference.rotation.transpose() * (place - reference.position));
}

SurfaceNode surface_node(const ReducedBody& body, int label) {
  const auto found = std::find(body.node_labels.begin(), body.node_labels.end(), label);
  if (found == body.node_labels.end()) return {-1, fmt::format("the body's surface has no node {}", label)};
  return {static_cast<int>(found - body.node_labels.begin()), {}};
}

SurfaceNode surface_node(const ReducedBody& body, const spec::Pose& pose, const Eigen::Vector3d& place) {
  const Eigen::Vector3d wanted = pose.rotation.transpose() * (place - pose.position);
  Eigen::Index nearest = 0;
  const double distance = (body.nodes.colwise() - wanted).colwise().norm().minCoeff(&nearest);
  const double size = (body.nodes.rowwise().maxCoeff() - body.nodes.rowwise().minCoeff()).norm();
  return {static_cast<int>(nearest),
          distance > 0.02 * size
              ? fmt::format("the nearest node of the body's surface is {:.3g} m away", distance)
              : std::string()};
}

}  // namespace mimbre
