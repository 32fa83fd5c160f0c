#pragma once
#include <cmath>
#include <limits>

#include "math/elementary.h"
#include "mimbre/channels.h"
#include "mimbre/reduced_body.h"
#include "outputs/view.h"
#include "spec/check/checked_item.h"
#include "spec/output_kind.h"

namespace mimbre::outputs {

/// Of a flexible body made of bars: N, Vy, Vz, T, My, Mz, largest von Mises stress at `node`, the start (2 k)
/// or end (2 k + 1) of its mesh's element k. Of a rigid body 0, as stress is.
struct SectionForce {
  static const spec::Body& body_of(const spec::Model& model, const spec::Output& o) {
    return model.bodies[static_cast<std::size_t>(o.item)];
  }

  static void check(const spec::Model& model, const checks::CheckedItem& item, const spec::Output& o) {
    const spec::Body& body = body_of(model, o);
    if (!body.flexible) return;
    const auto& sections = body.flexible->sections;
    if (!sections)
      return item.error(fmt::format(
          "body '{}' knows no section forces: it is not made of bars, or was reduced without", body.name));
    if (!item.between("node", o.node, 0, static_cast<int>(sections->sections.size()) - 1)) return;
    if (o.component == von_mises_of_section &&
        !(sections->sections[static_cast<std::size_t>(o.node)].torsion_modulus > 0))
      item.error(
          "the section is given by area, Iy, Iz and J: its shape, and so its stress, is not known; give it "
          "'outermost: [y, z]' and 'torsion_modulus', too");
  }

  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    const char* const unit = o.component < 3 ? "N" : o.component < 6 ? "N m" : "Pa";
    const char* const component = section_components[static_cast<std::size_t>(o.component)];
    const spec::Body& body = body_of(m.spec(), o);
    if (!body.flexible || !body.flexible->sections)
      return {o.name, unit, fmt::format("{} in a section of '{}', which is rigid", component, body.name)};
    const auto& section = body.flexible->sections->sections[static_cast<std::size_t>(o.node)];
    return {
        o.name, unit,
        fmt::format(
            "{} in '{}', bar '{}' at {:.6g} m, {} of its element {}, axes of the bar, on the part before it",
            component, body.name, section.bar, section.along, o.node % 2 == 1 ? "end" : "start",
            section.element)};
  }

  /// The largest von Mises stress, Pa: of the outermost fibres by N, My and Mz, and of the largest shear
  /// stress by T, as if both were at one place; shear stress by V, which is zero there, is left out. NaN
  /// where the section's shape is not known.
  static double largest_stress(const BarSections::Section& section, const Eigen::Matrix<double, 6, 1>& f) {
    if (!(section.reach_y > 0 && section.reach_z > 0 && section.torsion_modulus > 0))
      return std::numeric_limits<double>::quiet_NaN();
    const double about_y = f[4] * section.reach_z / section.Iy, about_z = f[5] * section.reach_y / section.Iz;
    const double bending =
        section.round ? mimbre::hypot(about_y, about_z) : std::abs(about_y) + std::abs(about_z);
    return mimbre::hypot(std::abs(f[0]) / section.area + bending,
                         std::sqrt(3.0) * f[3] / section.torsion_modulus);
  }

  static double value(const OutputView& view, const spec::Output& o) {
    const spec::Body& body = body_of(view.spec(), o);
    if (!body.flexible) return 0;
    const auto forces = view.section_forces(o.item, o.node);
    return o.component < 6
               ? forces[o.component]
               : largest_stress(body.flexible->sections->sections[static_cast<std::size_t>(o.node)], forces);
  }

  static constexpr OutputInfo info{.name = "section_force",
                                   .of = OutputInfo::Of::body,
                                   .words = section_components,
                                   .place = OutputInfo::Place::section,
                                   .needs = OutputInfo::Needs::reactions,
                                   .check = check,
                                   .describe = describe,
                                   .value = value};
};

}  // namespace mimbre::outputs
