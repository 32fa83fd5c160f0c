#include "spec/contact_pairs.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "mimbre/reduced_body.h"

namespace mimbre {
namespace {

/// A frame for every node of the body's surface.
std::vector<int> surface_frames(spec::Model& model, int body) {
  const ReducedBody& flexible = *model.bodies[static_cast<std::size_t>(body)].flexible;
  std::set<int> nodes;
  for (const auto& triangle : flexible.triangles) nodes.insert(triangle.begin(), triangle.end());
  std::vector<int> frames;
  for (const int node : nodes) {
    spec::Frame frame;
    frame.name = fmt::format("{}.surface.{}", model.bodies[static_cast<std::size_t>(body)].name, node);
    frame.body = body;
    frame.pose.position = flexible.nodes.col(node);
    frame.node = node;
    frames.push_back(static_cast<int>(model.frames.size()));
    model.frames.push_back(std::move(frame));
  }
  return frames;
}

}  // namespace

ContactPairs contact_pairs(spec::Model& model) {
  ContactPairs found;
  std::vector<ContactPair>& pairs = found.pairs;
  const auto body = [&](int frame) { return model.frames[static_cast<std::size_t>(frame)].body; };
  for (int k = 0; k < static_cast<int>(model.contacts.size()); ++k) {
    const spec::Contact& contact = model.contacts[static_cast<std::size_t>(k)];
    std::vector<ContactSphere> spheres;
    for (const spec::Spheres& set : contact.spheres) {
      const std::vector<int> frames = set.surface_of < 0 ? set.frames : surface_frames(model, set.surface_of);
      for (const int frame : frames) spheres.push_back({frame, set.radius});
    }
    for (std::size_t i = 0; i < spheres.size(); ++i) {
      for (const int surface : contact.surfaces) {
        const int carrier = model.surfaces[static_cast<std::size_t>(surface)].frame;
        if (body(carrier) != body(spheres[i].frame))
          pairs.push_back({k, surface, carrier, spheres[i].frame, spheres[i].radius, 0});
      }
      for (std::size_t j = 0; contact.among && !contact.swarm && j < i; ++j)
        if (body(spheres[j].frame) != body(spheres[i].frame))
          pairs.push_back({k, -1, spheres[j].frame, spheres[i].frame, spheres[i].radius, spheres[j].radius});
    }
    found.swarms.push_back(contact.swarm ? std::move(spheres) : std::vector<ContactSphere>());
  }
  return found;
}

}  // namespace mimbre
