#include <algorithm>

#include "joints/joint_kind.h"
#include "math/stress.h"
#include "mimbre/reduced_body.h"
#include "spec/checked_item.h"
#include "spec/force_law.h"
#include "spec/output_kinds.h"

/// Channels that the user named.
namespace mimbre::checks {
namespace {

int components(spec::Element::On on) {
  return on == spec::Element::On::frames ? 6 : on == spec::Element::On::velocity ? 3 : 1;
}

using Measured = spec::Output::Kind;

void check_direction(const CheckedItem& item, const Eigen::Vector3d& direction) {
  if (item.finite("direction", direction) && direction.isZero(0))
    item.error("direction has no length; give a vector such as (0, 0, 1)");
}

void check_joint(const spec::Model& model, const CheckedItem& item, const spec::Output& output) {
  if (!item.index("item", output.item, model.joints.size(), "joints")) return;
  if (output.kind == Measured::joint_force) {
    item.between("component", output.component, 0, 5);
    return;
  }
  const spec::JointType type = model.joints[static_cast<std::size_t>(output.item)].type;
  if (!is_joint(type)) return;  // reported already
  const JointInfo& info = joint_info(type);
  if (output.kind == Measured::joint_rotation || output.kind == Measured::joint_quaternion) {
    if (info.quaternion < 0)
      item.error(fmt::format("a {} joint has no quaternion; its coordinates are its angles", info.name));
    else
      item.between("component", output.component, 0, output.kind == Measured::joint_rotation ? 2 : 3);
    return;
  }
  const bool rate = output.kind == Measured::joint_velocity || output.kind == Measured::joint_acceleration;
  const int count = info.quaternion < 0 || rate ? info.velocities : info.quaternion;
  if (count == 0)
    item.error(fmt::format("a {} joint has no {} coordinate", info.name, rate ? "" : "scalar"));
  else
    item.between("component", output.component, 0, count - 1);
}

const spec::Body* body_of(const spec::Model& model, const CheckedItem& item, int index) {
  return item.index("item", index, model.bodies.size(), "bodies")
             ? &model.bodies[static_cast<std::size_t>(index)]
             : nullptr;
}

void check_amplitude(const spec::Model& model, const CheckedItem& item, const spec::Output& output) {
  const spec::Body* body = body_of(model, item, output.item);
  if (!body) return;
  if (!body->flexible || body->flexible->modes == 0)
    item.error(fmt::format("body '{}' is rigid and has no modes", body->name));
  else
    item.between("component", output.component, 0, body->flexible->modes - 1);
}

/// Of a rigid body stress and strain are 0, which is allowed: a model may have a body in both ways.
void check_stress(const spec::Model& model, const CheckedItem& item, const spec::Output& output) {
  const bool stress = output.kind == Measured::stress;
  item.between("component", output.component, 0, stress ? von_mises_component : von_mises_component - 1);
  if (item.finite("direction", output.direction) && stress && !output.direction.isZero(0))
    item.error("a direction belongs to a strain, not to a stress");
  const spec::Body* body = body_of(model, item, output.item);
  if (!body || !body->flexible) return;
  if ((stress ? body->flexible->stress : body->flexible->strain).size() == 0)
    item.error(fmt::format("body '{}' has no {} modes; reduce its model again, with its elements", body->name,
                           stress ? "stress" : "strain"));
  item.between("node", output.node, -1, static_cast<int>(body->flexible->nodes.cols()) - 1);
}

/// Of a rigid body they are 0, as stress is.
void check_section_force(const spec::Model& model, const CheckedItem& item, const spec::Output& output) {
  const spec::Body* body = body_of(model, item, output.item);
  item.between("component", output.component, 0, static_cast<int>(section_components.size()) - 1);
  if (!body || !body->flexible) return;
  const auto& sections = body->flexible->sections;
  if (!sections)
    return item.error(fmt::format(
        "body '{}' knows no section forces: it is not made of bars, or was reduced without", body->name));
  if (!item.between("node", output.node, 0, static_cast<int>(sections->sections.size()) - 1)) return;
  if (output.component == von_mises_of_section &&
      !(sections->sections[static_cast<std::size_t>(output.node)].torsion_modulus > 0))
    item.error(
        "the section is given by area, Iy, Iz and J: its shape, and so its stress, is not known; give it "
        "'outermost: [y, z]' and 'torsion_modulus', too");
}

void check_motion_of_mass(const spec::Model& model, const CheckedItem& item, const spec::Output& output) {
  item.between("component", output.component, 0, 2);
  if (output.about) item.finite("about", *output.about);
  double mass = 0;
  const auto add = [&](const spec::Body& body) { mass += body.flexible ? body.flexible->mass : body.mass; };
  for (std::size_t k = 0; k < output.bodies.size(); ++k) {
    const int body = output.bodies[k];
    if (!item.index("one of bodies", body, model.bodies.size(), "bodies")) return;
    if (std::find(output.bodies.begin(), output.bodies.begin() + static_cast<std::ptrdiff_t>(k), body) !=
        output.bodies.begin() + static_cast<std::ptrdiff_t>(k))
      return item.error(
          fmt::format("body '{}' is named twice", model.bodies[static_cast<std::size_t>(body)].name));
    add(model.bodies[static_cast<std::size_t>(body)]);
  }
  if (output.bodies.empty()) std::for_each(model.bodies.begin(), model.bodies.end(), add);
  if (mass == 0) item.error("has no mass, and so neither a centre of mass nor momentum");
}

/// Commas and quotes would break the columns of a CSV file.
void check_name(const CheckedItem& item, const std::string& name) {
  const auto good = [](char c) {
    return static_cast<unsigned char>(c) >= 0x20 && c != ',' && c != '"' && c != 0x7f;
  };
  if (name.size() > 100 || !std::all_of(name.begin(), name.end(), good))
    item.error("is no name of a column; it has 1 to 100 characters, no comma and no quote");
  if (name == "t") item.error("'t' is the column of the time; choose another name");
}

/// A tyre that only carries has its vertical force and nothing else.
void check_tyre(const spec::Model& model, const CheckedItem& item, const spec::Output& output) {
  const auto last = [](const auto& components) { return static_cast<int>(components.size()) - 1; };
  if (output.kind == Measured::tyre_force)
    item.between("component", output.component, 0, last(tyre_force_components));
  if (output.kind == Measured::tyre_moment)
    item.between("component", output.component, 0, last(tyre_moment_components));
  if (!item.index("item", output.item, model.tyres.size(), "tyres")) return;
  if (output.kind == Measured::tyre_force && output.component == 0) return;
  const spec::Tyre& tyre = model.tyres[static_cast<std::size_t>(output.item)];
  const int law = find_law(tyre.law);
  if (law >= 0 && !law_info(law).rolling_size)
    item.error(
        fmt::format("tyre '{}' only carries and has no more than a vertical force; give it a model: "
                    "brush or magic_formula",
                    tyre.name));
}

/// Of a body that never touches anything there it would be 0 always.
void check_contact(const spec::Model& model, const CheckedItem& item, const spec::Output& output) {
  if (output.kind == Measured::contact_force)
    item.between("component", output.component, 0, static_cast<int>(contact_components.size()) - 1);
  if (!item.index("item", output.item, model.contacts.size(), "contacts") || output.bodies.empty()) return;
  const int body = output.bodies.front();
  if (output.bodies.size() > 1) return item.error("is of one body of a contact, or of all spheres of it");
  if (!item.index("bodies", body, model.bodies.size(), "bodies")) return;
  const spec::Contact& contact = model.contacts[static_cast<std::size_t>(output.item)];
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

void check_output(const spec::Model& model, const CheckedItem& item, const spec::Output& output) {
  check_name(item, output.name);
  item.finite("offset", output.offset);
  switch (output.kind) {
    case Measured::position:
    case Measured::velocity:
    case Measured::acceleration:
    case Measured::angular_velocity:
      item.between("component", output.component, 0, 2);
      item.index("item", output.item, model.frames.size(), "frames");
      return;
    case Measured::roll:
    case Measured::pitch:
    case Measured::yaw:
      item.index("item", output.item, model.frames.size(), "frames");
      return;
    case Measured::displacement:
      item.index("reference", output.reference, model.frames.size(), "frames");
      [[fallthrough]];
    case Measured::deflection:
      item.index("item", output.item, model.frames.size(), "frames");
      return check_direction(item, output.direction);
    case Measured::joint_position:
    case Measured::joint_velocity:
    case Measured::joint_acceleration:
    case Measured::joint_rotation:
    case Measured::joint_quaternion:
    case Measured::joint_force:
      return check_joint(model, item, output);
    case Measured::modal_amplitude:
      return check_amplitude(model, item, output);
    case Measured::stress:
    case Measured::strain:
      return check_stress(model, item, output);
    case Measured::section_force:
      return check_section_force(model, item, output);
    case Measured::centre_of_mass:
    case Measured::linear_momentum:
    case Measured::angular_momentum:
      return check_motion_of_mass(model, item, output);
    case Measured::spring_force:
    case Measured::spring_length:
      item.index("item", output.item, model.springs.size(), "springs");
      return;
    case Measured::tyre_force:
    case Measured::tyre_moment:
    case Measured::tyre_slip:
    case Measured::tyre_slip_angle:
    case Measured::tyre_camber:
    case Measured::tyre_deflection:
      return check_tyre(model, item, output);
    case Measured::contact_force:
    case Measured::contact_depth:
    case Measured::contact_count:
      return check_contact(model, item, output);
    case Measured::signal:
      item.index("item", output.item, model.signals.size(), "signals");
      return;
    case Measured::input:
      item.index("item", output.item, model.inputs.size(), "inputs");
      return;
    case Measured::element_force:
    case Measured::element_measure:
    case Measured::element_rate:
      if (item.index("item", output.item, model.elements.size(), "elements"))
        item.between("component", output.component, 0,
                     components(model.elements[static_cast<std::size_t>(output.item)].on) - 1);
      return;
  }
  item.error(fmt::format("kind is {}, which is none of its choices", static_cast<int>(output.kind)));
}

}  // namespace

void check_outputs(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.outputs.size(); ++k)
    check_output(model, CheckedItem(errors, "output", model.outputs[k].name, model.outputs[k].mark, k),
                 model.outputs[k]);
  for (std::size_t k = 0; k < model.sensors.size(); ++k)
    check_output(model, CheckedItem(errors, "sensor", model.sensors[k].name, model.sensors[k].mark, k),
                 model.sensors[k]);
}

}  // namespace mimbre::checks
