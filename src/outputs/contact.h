#pragma once
#include <algorithm>

#include "mimbre/channels.h"
#include "outputs/mass_motion.h"
#include "outputs/view.h"
#include "spec/check/checked_item.h"
#include "spec/output_kind.h"

/// Of a contact on its spheres, or on one body.
namespace mimbre::outputs {

inline const std::string& contact_name(const Compiled& m, const spec::Output& o) {
  return m.spec().contacts[static_cast<std::size_t>(o.item)].name;
}

inline std::string at_body(const Compiled& m, const spec::Output& o) {
  return o.bodies.empty() ? std::string() : " at " + body_names(m, o);
}

inline ContactSum contact_of(const OutputView& view, const spec::Output& o) {
  return view.contact(o.item, o.bodies.empty() ? -1 : view.model.body_of_spec[o.bodies.front()]);
}

/// Of a body that never touches anything there it would be 0 always.
inline void check_contact_body(const spec::Model& model, const checks::CheckedItem& item,
                               const spec::Output& o) {
  if (o.bodies.empty()) return;
  const int body = o.bodies.front();
  if (o.bodies.size() > 1) return item.error("is of one body of a contact, or of all spheres of it");
  if (!item.index("bodies", body, model.bodies.size(), "bodies")) return;
  const spec::Contact& contact = model.contacts[static_cast<std::size_t>(o.item)];
  const auto on_body = [&](int frame) {
    return frame >= 0 && static_cast<std::size_t>(frame) < model.frames.size() &&
           model.frames[static_cast<std::size_t>(frame)].body == body;
  };
  const bool carries = std::any_of(contact.spheres.begin(), contact.spheres.end(), [&](const auto& set) {
    return set.surface_of == body || std::any_of(set.frames.begin(), set.frames.end(), on_body);
  });
  const bool is_touched = std::any_of(contact.surfaces.begin(), contact.surfaces.end(), [&](int surface) {
    return surface >= 0 && static_cast<std::size_t>(surface) < model.surfaces.size() &&
           on_body(model.surfaces[static_cast<std::size_t>(surface)].frame);
  });
  if (!carries && !is_touched)
    item.error(fmt::format("body '{}' has neither spheres nor surfaces of contact '{}'",
                           model.bodies[static_cast<std::size_t>(body)].name, contact.name));
}

/// Along the global axes, and sums of the magnitudes of normal and tangential forces.
struct ContactForce {
  static constexpr const char* words[] = {"x", "y", "z", "normal", "tangential"};
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    const std::string on = o.bodies.empty() ? "its spheres" : body_names(m, o), contact = contact_name(m, o);
    const char* const component = words[o.component];
    return {o.name, "N",
            o.component < 3
                ? fmt::format("force of contact '{}' on {}, {} of the global axes", contact, on, component)
                : fmt::format("sum of the {} forces of contact '{}' on {}", component, contact, on)};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    const ContactSum sum = contact_of(view, o);
    return o.component < 3 ? sum.force[o.component] : o.component == 3 ? sum.normal : sum.tangential;
  }
  static constexpr OutputInfo info{.name = "contact_force",
                                   .of = OutputInfo::Of::contact,
                                   .words = words,
                                   .needs = OutputInfo::Needs::forces,
                                   .check = check_contact_body,
                                   .describe = describe,
                                   .value = value};
};

/// The largest.
struct ContactDepth {
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return {o.name, "m", fmt::format("largest depth of contact '{}'{}", contact_name(m, o), at_body(m, o))};
  }
  static double value(const OutputView& view, const spec::Output& o) { return contact_of(view, o).depth; }
  static constexpr OutputInfo info{.name = "contact_depth",
                                   .of = OutputInfo::Of::contact,
                                   .needs = OutputInfo::Needs::forces,
                                   .check = check_contact_body,
                                   .describe = describe,
                                   .value = value};
};

/// Pairs that touch.
struct ContactCount {
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    return {o.name, "1",
            fmt::format("pairs of contact '{}' that touch{}", contact_name(m, o), at_body(m, o))};
  }
  static double value(const OutputView& view, const spec::Output& o) { return contact_of(view, o).count; }
  static constexpr OutputInfo info{.name = "contact_count",
                                   .of = OutputInfo::Of::contact,
                                   .needs = OutputInfo::Needs::forces,
                                   .check = check_contact_body,
                                   .describe = describe,
                                   .value = value};
};

}  // namespace mimbre::outputs
