#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "mimbre/reduced_body.h"
#include "model_file/sections/kept_reductions.h"
#include "model_file/text/builder.h"

namespace mimbre::model_file {
namespace {

/// Whether both give the same reduced body.
bool same(const FlexibleDescription& a, const FlexibleDescription& b) {
  const auto near = [](const auto& x, const auto& y, double size) { return (x - y).norm() <= 1e-9 * size; };
  if (a.mesh.nodes.cols() != b.mesh.nodes.cols() || a.mesh.elements.size() != b.mesh.elements.size() ||
      a.options.sections != b.options.sections || a.options.boundary.size() != b.options.boundary.size() ||
      a.frames.size() != b.frames.size())
    return false;
  const double size = a.mesh.nodes.norm();
  if (!near(a.mesh.nodes, b.mesh.nodes, size)) return false;
  for (std::size_t k = 0; k < a.mesh.elements.size(); ++k) {
    const auto &e = a.mesh.elements[k], &f = b.mesh.elements[k];
    const auto numbers = [](const fe::BeamElement& x) {
      return std::array{x.section.area,    x.section.Iy,       x.section.Iz,
                        x.section.J,       x.section.shear_y,  x.section.shear_z,
                        x.section.reach_y, x.section.reach_z,  x.section.torsion_modulus,
                        x.material.young,  x.material.poisson, x.material.density};
    };
    if (e.nodes != f.nodes || e.theory != f.theory || e.section.round != f.section.round ||
        !near(e.offsets[0], f.offsets[0], size) || !near(e.offsets[1], f.offsets[1], size) ||
        !near(e.y_direction, f.y_direction, 1) || numbers(e) != numbers(f) ||
        (a.options.sections && e.bar != f.bar))
      return false;
  }
  for (std::size_t k = 0; k < a.options.boundary.size(); ++k) {
    const auto &d = a.options.boundary[k], &e = b.options.boundary[k];
    if (d.node != e.node || d.rotation != e.rotation || d.name != e.name ||
        !near(d.direction, e.direction, 1))
      return false;
  }
  for (std::size_t k = 0; k < a.frames.size(); ++k)
    if (a.frames[k].name != b.frames[k].name) return false;
  return a.options.clamped_nodes == b.options.clamped_nodes && a.options.fixed_dofs == b.options.fixed_dofs &&
         a.options.dynamic_modes == b.options.dynamic_modes &&
         a.options.axial_dynamic_modes == b.options.axial_dynamic_modes &&
         a.options.stiffening == b.options.stiffening && a.options.mass_matrix == b.options.mass_matrix &&
         a.options.published_force == b.options.published_force &&
         a.options.boundary_rotation == b.options.boundary_rotation && a.kind == b.kind &&
         near(a.normal, b.normal, 1) && a.options.stiffness_damping == b.options.stiffness_damping;
}

ReducedBody make_reduced(const FlexibleDescription& d) {
  if (!d.by_ancf()) return fe::reduce(d.mesh, d.options, d.frames);
  const AncfKind kind = d.kind == BeamKind::ancf         ? AncfKind::planar
                        : d.kind == BeamKind::ancf_cable ? AncfKind::cable
                                                         : AncfKind::thick;
  return fe::ancf_beam(d.mesh, {kind, d.options.clamped_nodes.front(), d.normal, d.options.stiffness_damping},
                       d.frames);
}

}  // namespace

void reduce_bodies(Builder& builder) {
  std::vector<std::pair<const FlexibleDescription*, std::shared_ptr<const ReducedBody>>> done;
  std::size_t elements = 0;
  for (std::size_t k = 0; k < builder.bodies.size(); ++k) {
    const auto& description = builder.bodies[k].description;
    if (!description || !builder.bodies[k].flexible) continue;
    spec::Body& body = builder.model.bodies[k];
    for (const auto& [other, reduced] : done)
      if (!body.flexible && same(*other, *description)) body.flexible = reduced;
    if (body.flexible) continue;
    elements += description->mesh.elements.size();
    if (elements > static_cast<std::size_t>(builder.limits.all_elements)) {
      builder.errors.add(
          description->mark,
          fmt::format("the model has more than {} different finite elements", builder.limits.all_elements));
      return;
    }
    try {
      const std::string content = content_of(*description, body.name);
      body.flexible = find_reduced(content);
      if (!body.flexible) {
        auto reduced = std::make_shared<ReducedBody>(make_reduced(*description));
        reduced->name = body.name;
        reduced->line_radius = description->line_radius;
        body.flexible = std::move(reduced);
        keep_reduced(content, body.flexible);
      }
      done.emplace_back(&*description, body.flexible);
    } catch (const std::invalid_argument& e) {
      builder.errors.add(description->mark, fmt::format("{}: {}", description->what, e.what()));
    } catch (const std::runtime_error& e) {
      builder.errors.add(description->mark, fmt::format("{}: {}", description->what, e.what()));
    }
  }
}

}  // namespace mimbre::model_file
