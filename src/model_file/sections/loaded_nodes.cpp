#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string_view>

#include "joints/joint_kind.h"
#include "model_file/text/builder.h"

/// Forces where no mode answers to them.
namespace mimbre::model_file {
namespace {

/// Whether forces at a named node of the body are felt through a static mode, or not at all.
bool answers(const FlexibleDescription& d, int node) {
  const auto& held = d.options.clamped_nodes;
  return std::find(held.begin(), held.end(), node) != held.end() ||
         std::any_of(d.options.boundary.begin(), d.options.boundary.end(),
                     [&](const auto& dof) { return dof.node == node; });
}

}  // namespace

void warn_of_loaded_nodes(Builder& builder) {
  std::set<std::pair<int, int>> reported;  // bodies and nodes
  const auto look = [&](std::string_view kind, const std::string& name, const Mark& mark, int frame) {
    if (frame < 0) return;
    const spec::Frame& f = builder.model.frames[static_cast<std::size_t>(frame)];
    if (f.body < 0 || f.flexible_frame < 0) return;
    const BodyInfo& body = builder.bodies[static_cast<std::size_t>(f.body)];
    if (!body.description || body.description->kind != BeamKind::reduced || body.description->in_pieces() ||
        answers(*body.description, f.flexible_frame) || !reported.emplace(f.body, f.flexible_frame).second)
      return;
    const std::string& node = body.node_names[static_cast<std::size_t>(f.flexible_frame)];
    builder.warnings.push_back(
        {mark, fmt::format("{} '{}' acts on node '{}' of body '{}', which has no static mode: dynamic modes "
                           "alone represent its deflection by a force there poorly; add {{node: {}, along: "
                           "[..]}} or {{node: {}, all: true}} to its static_modes",
                           kind, name, node, builder.model.bodies[static_cast<std::size_t>(f.body)].name,
                           node, node)});
  };
  for (const spec::Joint& joint : builder.model.joints)
    if (!joint_info(joint.type).free())  // which carries no force
      for (const int frame : {joint.frame_a, joint.frame_b}) look("joint", joint.name, joint.mark, frame);
  for (const spec::Constraint& constraint : builder.model.constraints)
    for (const int frame : {constraint.frame_a, constraint.frame_b})
      look("constraint", constraint.name, constraint.mark, frame);
  for (const spec::Load& load : builder.model.loads) look("load", load.name, load.mark, load.frame);
  for (const spec::Spring& spring : builder.model.springs)
    for (const int frame : {spring.frame_a, spring.frame_b}) look("spring", spring.name, spring.mark, frame);
  for (const spec::Tyre& tyre : builder.model.tyres) look("tyre", tyre.name, tyre.mark, tyre.frame);
  for (const spec::Element& e : builder.model.elements) {
    for (const int frame : {e.frame_a, e.frame_b}) look(e.law, e.name, e.mark, frame);
    for (const int frame : e.path) look(e.law, e.name, e.mark, frame);
  }
}

}  // namespace mimbre::model_file
