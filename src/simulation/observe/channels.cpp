#include "simulation/observe/channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/amplitudes.h"
#include "dynamics/relative/kinematics.h"
#include "dynamics/relative/momentum.h"
#include "math/elementary.h"
#include "math/stress.h"
#include "mimbre/reduced_body.h"
#include "simulation/describe/contact_drawings.h"
#include "simulation/describe/names.h"
#include "simulation/observe/constraint_channels.h"
#include "simulation/observe/contact_channels.h"
#include "simulation/observe/section_forces.h"
#include "simulation/observe/wheel_channels.h"
#include "spec/output_kinds.h"

namespace mimbre {
namespace {

using Measured = spec::Output::Kind;

/// 'a', 'b' of the bodies, for people.
std::string names(const Compiled& m, const spec::Output& o) {
  if (o.bodies.empty()) return "all bodies";
  std::string text;
  for (const int b : o.bodies)
    text +=
        fmt::format("{}'{}'", text.empty() ? "" : ", ", m.spec().bodies[static_cast<std::size_t>(b)].name);
  return text;
}

double motion_of_mass(const spec::Output& o, const relative::Momentum& of, const Vec3d& origin) {
  if (o.kind == Measured::linear_momentum) return of.linear[o.component];
  const Vec3d centre = of.centre + origin;
  if (o.kind == Measured::centre_of_mass) return centre[o.component];
  if (!o.about) return of.angular[o.component];
  const Vec3d arm = centre - *o.about;
  return (of.angular + arm.cross(of.linear))[o.component];
}

/// What a reader of reactions may not know of the joint.
const char* joint_note(spec::JointType type) {
  return type == spec::JointType::bracket
             ? " (a bracket: fixed, and a flexible body gets static modes for it)"
             : "";
}

/// What the components of an element are called, and their units: force, measure, rate.
struct ComponentNames {
  std::string name, force, measure, rate;
};
ComponentNames component_names(const ElementData& e, int k) {
  static const char* const axes[] = {"x", "y", "z"};
  if (e.measure == Measure::relative)
    return k < 3 ? ComponentNames{std::string(".") + axes[k], "N", "m", "m/s"}
                 : ComponentNames{std::string(".r") + axes[k - 3], "N m", "rad", "rad/s"};
  if (e.measure == Measure::velocity) return {std::string(".") + axes[k], "N", "m/s", "m/s"};
  const bool turns = e.measure == Measure::coordinate ? is_angle(e.joint, e.local) : e.about;
  return turns ? ComponentNames{"", "N m", "rad", "rad/s"} : ComponentNames{"", "N", "m", "m/s"};
}

ChannelInfo output_info(const Compiled& m, const spec::Output& o) {
  static const char* const axes[] = {"x", "y", "z"};
  const auto frame = [&] { return m.spec().frames[o.item].name; };
  const auto joint = [&] { return m.spec().joints[o.item].name; };
  const auto angle = [&] { return is_angle(m.spec().joints[o.item].type, o.component); };
  const auto contact = [&] { return m.spec().contacts[static_cast<std::size_t>(o.item)].name; };
  const auto at_body = [&] { return o.bodies.empty() ? std::string() : " at " + names(m, o); };
  switch (o.kind) {
    case Measured::position:
      return {o.name, "m", fmt::format("global {} of '{}'", axes[o.component], frame())};
    case Measured::velocity:
      return {o.name, "m/s", fmt::format("global {} velocity of '{}'", axes[o.component], frame())};
    case Measured::acceleration:
      return {o.name, "m/s²", fmt::format("global {} acceleration of '{}'", axes[o.component], frame())};
    case Measured::roll:
      return {o.name, "rad", fmt::format("roll of '{}'", frame())};
    case Measured::pitch:
      return {o.name, "rad", fmt::format("pitch of '{}' (nose down positive)", frame())};
    case Measured::yaw:
      return {o.name, "rad", fmt::format("yaw of '{}'", frame())};
    case Measured::joint_position:
      return {o.name, angle() ? "rad" : "m",
              fmt::format("coordinate {} of joint '{}'", o.component, joint())};
    case Measured::joint_velocity:
      return {o.name, angle() ? "rad/s" : "m/s",
              fmt::format("rate of coordinate {} of joint '{}'", o.component, joint())};
    case Measured::joint_acceleration:
      return {o.name, angle() ? "rad/s²" : "m/s²",
              fmt::format("acceleration of coordinate {} of joint '{}'", o.component, joint())};
    case Measured::joint_rotation:
      return {o.name, "rad",
              fmt::format(
                  "rotation vector of joint '{}', its second body against the first, {} of the first's axes",
                  joint(), axes[o.component])};
    case Measured::joint_quaternion:
      return {o.name, "1",
              fmt::format("quaternion {} of joint '{}', its second body's axes to the first's",
                          std::array{"w", "x", "y", "z"}[static_cast<std::size_t>(o.component)], joint())};
    case Measured::joint_force:
      return {
          o.name, o.component < 3 ? "N" : "N m",
          fmt::format("reaction {} of joint '{}' on its second body, at the joint's point there, {} of the "
                      "global axes{}",
                      o.component < 3 ? "force" : "moment", joint(), axes[o.component % 3],
                      joint_note(m.spec().joints[o.item].type))};
    case Measured::deflection:
      return {o.name, "m", fmt::format("deflection of '{}'", frame())};
    case Measured::displacement:
      return {o.name, "m",
              fmt::format("displacement of '{}' in the axes of '{}'", frame(),
                          m.spec().frames[o.reference].name)};
    case Measured::modal_amplitude:
      return {o.name, "1", fmt::format("amplitude {} of '{}'", o.component, m.spec().bodies[o.item].name)};
    case Measured::stress:
    case Measured::strain: {
      const bool stress = o.kind == Measured::stress;
      const std::string what = o.direction.isZero(0) ? fmt::format("{} {}", stress ? "stress" : "strain",
                                                                   stress_components[o.component])
                                                     : "elongation";
      const spec::Body& body = m.spec().bodies[o.item];
      std::string place = "largest";
      if (o.node >= 0 && body.flexible)
        place = body.flexible->node_labels.empty()
                    ? fmt::format("point {}", o.node)
                    : fmt::format("node {}", body.flexible->node_labels[o.node]);
      return {o.name, stress ? "Pa" : "1", fmt::format("{} of '{}', {}", what, body.name, place)};
    }
    case Measured::spring_force:
      return {o.name, "N", fmt::format("tension of spring '{}'", m.spec().springs[o.item].name)};
    case Measured::spring_length:
      return {o.name, "m", fmt::format("length of spring '{}'", m.spec().springs[o.item].name)};
    case Measured::tyre_force:
    case Measured::tyre_moment:
    case Measured::tyre_slip:
    case Measured::tyre_slip_angle:
    case Measured::tyre_camber:
    case Measured::tyre_deflection:
      return wheel_output_info(m.spec().tyres[o.item].name, o);
    case Measured::contact_force: {
      const std::string on = o.bodies.empty() ? "its spheres" : names(m, o);
      const char* const component = contact_components[static_cast<std::size_t>(o.component)];
      return {
          o.name, "N",
          o.component < 3
              ? fmt::format("force of contact '{}' on {}, {} of the global axes", contact(), on, component)
              : fmt::format("sum of the {} forces of contact '{}' on {}", component, contact(), on)};
    }
    case Measured::contact_depth:
      return {o.name, "m", fmt::format("largest depth of contact '{}'{}", contact(), at_body())};
    case Measured::contact_count:
      return {o.name, "1", fmt::format("pairs of contact '{}' that touch{}", contact(), at_body())};
    case Measured::signal:
      return {o.name, m.spec().signals[o.item].unit.empty() ? "1" : m.spec().signals[o.item].unit,
              fmt::format("signal '{}'", m.spec().signals[o.item].name)};
    case Measured::input:
      return {o.name, m.spec().inputs[o.item].unit.empty() ? "1" : m.spec().inputs[o.item].unit,
              fmt::format("input '{}'", m.spec().inputs[o.item].name)};
    case Measured::element_force:
    case Measured::element_measure:
    case Measured::element_rate: {
      const ElementData& e = m.elements[m.first_other + o.item];
      const ComponentNames called = component_names(e, o.component);
      const std::string of = element_name(m, e);
      if (o.kind == Measured::element_force) return {o.name, called.force, "force of " + of};
      if (o.kind == Measured::element_measure) return {o.name, called.measure, "what " + of + " measures"};
      return {o.name, called.rate, "rate of what " + of + " measures"};
    }
    case Measured::section_force: {
      const char* const unit = o.component < 3 ? "N" : o.component < 6 ? "N m" : "Pa";
      const char* const component = section_components[static_cast<std::size_t>(o.component)];
      const spec::Body& body = m.spec().bodies[o.item];
      if (!body.flexible || !body.flexible->sections)
        return {o.name, unit, fmt::format("{} in a section of '{}', which is rigid", component, body.name)};
      const auto& section = body.flexible->sections->sections[static_cast<std::size_t>(o.node)];
      return {o.name, unit,
              fmt::format("{} in '{}', bar '{}' at {:.6g} m, {} of its element {}, axes of the bar, on the "
                          "part before it",
                          component, body.name, section.bar, section.along, o.node % 2 == 1 ? "end" : "start",
                          section.element)};
    }
    case Measured::angular_velocity:
      return {o.name, "rad/s",
              fmt::format("angular velocity of '{}' about {} of {} axes", frame(), axes[o.component],
                          o.own_axes ? "its own" : "the global")};
    case Measured::centre_of_mass:
      return {o.name, "m",
              fmt::format("global {} of the centre of mass of {}", axes[o.component], names(m, o))};
    case Measured::linear_momentum:
      return {o.name, "kg m/s", fmt::format("global {} momentum of {}", axes[o.component], names(m, o))};
    case Measured::angular_momentum:
      return {
          o.name, "kg m²/s",
          fmt::format("global {} angular momentum of {} about {}", axes[o.component], names(m, o),
                      o.about ? fmt::format("[{:g}, {:g}, {:g}]", (*o.about)[0], (*o.about)[1], (*o.about)[2])
                              : std::string("their centre of mass"))};
  }
  return {};
}

/// What a load exerts at all: each has channels only where it is not nothing.
const Vec3d& given(const ElementData& load, bool moment) { return moment ? load.second : load.direction; }

/// Of the smallest principal value the smallest, of all others the one of the largest magnitude.
bool more_extreme(int component, double a, double b) {
  if (component == 6) return a > b;
  if (component == 7) return a < b;
  return std::abs(a) > std::abs(b);
}

double stress_or_strain(const spec::Output& o, const ReducedBody& body,
                        const Eigen::Ref<const Eigen::VectorXd>& y) {
  const bool stress = o.kind == Measured::stress;
  const Eigen::MatrixXd& shapes = stress ? body.stress : body.strain;
  const auto value = [&](const Vector6& here) {
    if (!o.direction.isZero(0)) return elongation(here, o.direction);
    return stress || o.component < 6 ? stress_component(here, o.component)
                                     : stress_component(tensor_strain(here), o.component);
  };
  if (o.node >= 0) return value(shapes.middleRows<6>(6 * o.node) * y);
  double extreme = value(shapes.topRows<6>() * y);
  for (Eigen::Index at = 6; at < shapes.rows(); at += 6)
    if (const double here = value(shapes.middleRows<6>(at) * y); more_extreme(o.component, here, extreme))
      extreme = here;
  return extreme;
}

}  // namespace

Channels::Needs Channels::needs_of(Measured kind) {
  switch (kind) {
    case Measured::joint_force:
    case Measured::section_force:
      return Channels::Needs::reactions;
    case Measured::spring_force:
    case Measured::spring_length:
    case Measured::tyre_force:
    case Measured::tyre_moment:
    case Measured::tyre_slip:
    case Measured::tyre_slip_angle:
    case Measured::tyre_camber:
    case Measured::tyre_deflection:
    case Measured::contact_force:
    case Measured::contact_depth:
    case Measured::contact_count:
    case Measured::signal:
    case Measured::input:
    case Measured::element_force:
    case Measured::element_measure:
    case Measured::element_rate:
      return Channels::Needs::forces;
    default:
      return Channels::Needs::motion;
  }
}

std::vector<int> bodies_of(const Compiled& m, const spec::Output& o) {
  std::vector<int> bodies;
  if (o.kind != Measured::centre_of_mass && o.kind != Measured::linear_momentum &&
      o.kind != Measured::angular_momentum)
    return bodies;
  for (const int b : o.bodies) bodies.push_back(m.body_of_spec[static_cast<std::size_t>(b)]);
  if (o.bodies.empty())
    for (int b = 0; b < static_cast<int>(m.bodies.size()); ++b) bodies.push_back(b);
  return bodies;
}

void Channels::add(Part::Kind kind, int item, Needs needs, std::size_t first) {
  const int count = static_cast<int>(info_.size() - first);
  if (count == 0) return;
  part_of_.resize(info_.size(), static_cast<int>(parts_.size()));
  parts_.push_back({kind, item, static_cast<int>(first), count, needs});
}

Channels::Channels(const Compiled& m) : model_(m), draws_ground_(draws_ground(m.spec())), joints_(m) {
  using Of = Part::Kind;
  for (const BodyData& b : m.bodies)
    if (b.modes > 0) modes_ += m.flexible[b.flexible].modes;
  const auto add_with = [&](Of kind, int item, Needs needs, const auto& describe) {
    const std::size_t first = info_.size();
    describe();
    add(kind, item, needs, first);
  };
  for (int k = 0; k < static_cast<int>(m.spec().outputs.size()); ++k) {
    const spec::Output& o = m.spec().outputs[static_cast<std::size_t>(k)];
    add_with(Of::output, k, needs_of(o.kind), [&] { info_.push_back(output_info(m, o)); });
    mass_of_output_.push_back(bodies_of(m, o));
    if (o.kind == Measured::joint_position) info_.back().alike = joints_.alike(o.item, o.component);
    if (o.kind == Measured::joint_quaternion) info_.back().alike = ChannelInfo::Alike::sign;
  }
  output_count_ = static_cast<int>(info_.size());
  for (int j = 0; j < static_cast<int>(m.spec().joints.size()); ++j) {
    add_with(Of::joint, j, Needs::motion, [&] { joints_.add_motion_info(j, info_); });
    add_with(Of::reaction, j, Needs::reactions, [&] { joints_.add_reaction_info(j, info_); });
  }
  for (int k = 0; k < m.first_tyre; ++k)
    add_with(Of::spring, k, Needs::forces, [&] {
      const std::string& name = m.spec().springs[static_cast<std::size_t>(k)].name;
      info_.push_back(
          {fmt::format("spring.{}.force", name), "N", fmt::format("tension of spring '{}'", name)});
      info_.push_back(
          {fmt::format("spring.{}.length", name), "m", fmt::format("length of spring '{}'", name)});
    });
  const auto tyre = [&](int k) -> const std::string& {
    return m.spec().tyres[static_cast<std::size_t>(k - m.first_tyre)].name;
  };
  for (int k = m.first_tyre; k < m.first_load; ++k)
    add_with(Of::tyre, k, Needs::forces, [&] {
      info_.push_back({fmt::format("tyre.{}.vertical", tyre(k)), "N",
                       fmt::format("vertical force of tyre '{}'", tyre(k))});
    });
  for (int k = m.first_tyre; k < m.first_load; ++k)
    if (m.elements[k].measure == Measure::wheel)
      add_with(Of::wheel, k, Needs::forces, [&] { add_wheel_info(tyre(k), info_); });
  for (int k = m.first_tyre; k < m.first_load; ++k)
    add_with(Of::road, k, Needs::forces, [&] {
      info_.push_back({fmt::format("tyre.{}.road", tyre(k)), "m",
                       fmt::format("global z of the road under tyre '{}'", tyre(k))});
    });
  for (int l = m.first_load; l < m.first_joint_spring; ++l)
    add_with(Of::load, l, Needs::forces, [&] {
      for (const bool moment : {false, true})
        for (int axis = 0; axis < 3 && !given(m.elements[l], moment).isZero(0); ++axis) {
          const std::string& name = m.spec().loads[m.elements[l].spec].name;
          const char* const what = moment ? "moment" : "force";
          info_.push_back({fmt::format("load.{}.{}.{}", name, what, "xyz"[axis]), moment ? "N m" : "N",
                           fmt::format("{} of load '{}', {} of the global axes", what, name, "xyz"[axis])});
        }
    });
  for (std::size_t k = 0; k < m.spec().elements.size(); ++k) {
    const int number = m.first_other + static_cast<int>(k);
    const ElementData& e = m.elements[number];
    const spec::Element& element = m.spec().elements[k];
    add_with(Of::element, number, Needs::forces, [&] {
      for (int c = 0; c < e.count; ++c) {
        const ComponentNames called = component_names(e, c);
        const std::string of = fmt::format("{}.{}", element.law, element.name), who = element_name(m, e);
        info_.push_back({fmt::format("{}.force{}", of, called.name), called.force,
                         fmt::format("force of {}, positive where it drives what it measures on", who)});
        info_.push_back({fmt::format("{}.measure{}", of, called.name), called.measure,
                         fmt::format("what {} measures", who)});
      }
    });
  }
  for (std::size_t k = 0; k < m.constraints.size(); ++k)
    add_with(Of::constraint, static_cast<int>(k), Needs::reactions,
             [&] { add_constraint_info(m, m.constraints[k], info_); });
  for (std::size_t k = 0; k < m.spec().contacts.size(); ++k)
    add_with(Of::contact, static_cast<int>(k), Needs::forces, [&] {
      const std::string& name = m.spec().contacts[k].name;
      const std::string of = fmt::format("contact.{}", name), who = fmt::format("contact '{}'", name);
      for (const char axis : {'x', 'y', 'z'})
        info_.push_back({fmt::format("{}.force.{}", of, axis), "N",
                         fmt::format("force on the spheres of {}, {} of the global axes", who, axis)});
      info_.push_back({of + ".normal", "N", fmt::format("sum of the normal forces of {}", who)});
      info_.push_back({of + ".depth", "m", fmt::format("largest depth of {}", who)});
      info_.push_back({of + ".count", "1", fmt::format("pairs of {} that touch", who)});
    });
  for (std::size_t k = 0; k < m.spec().inputs.size(); ++k)
    add_with(Of::input, m.signals.slot_of_input[k], Needs::forces, [&] {
      const spec::Input& i = m.spec().inputs[k];
      info_.push_back({fmt::format("input.{}", i.name), i.unit.empty() ? "1" : i.unit,
                       fmt::format("{} '{}'", i.tunable ? "parameter" : "input", i.name)});
    });
  for (std::size_t k = 0; k < m.spec().signals.size(); ++k)
    add_with(Of::signal, m.signals.slot_of_signal[k], Needs::forces, [&] {
      const spec::Signal& i = m.spec().signals[k];
      if (i.named)
        info_.push_back({fmt::format("signal.{}", i.name), i.unit.empty() ? "1" : i.unit,
                         fmt::format("signal '{}'", i.name)});
    });
  for (std::size_t k = 0; k < m.spec().events.size(); ++k)
    add_with(Of::event, static_cast<int>(k), Needs::motion, [&] {
      const std::string& name = m.spec().events[k].name;
      info_.push_back(
          {fmt::format("event.{}", name), "1", fmt::format("how often event '{}' has happened", name)});
      info_.push_back({fmt::format("event.{}.time", name), "s",
                       fmt::format("when event '{}' last happened; -1: not yet", name)});
    });
  add_with(Of::energy, 0, Needs::motion, [&] {
    for (const EnergyTerm& term : energy_terms)
      info_.push_back({fmt::format("energy.{}", term.name), "J", term.meaning});
  });
  add_with(Of::solver, 0, Needs::motion, [&] {
    info_.push_back({"solver.iterations", "1", "iterations of the last step"});
    info_.push_back(
        {"solver.position_violation", "m", "largest violation of the constraints that are lengths"});
    info_.push_back(
        {"solver.angle_violation", "rad", "largest violation of the constraints that are angles"});
    info_.push_back({"solver.velocity_violation", "m/s", "largest rate of the constraints that are lengths"});
    info_.push_back(
        {"solver.angular_velocity_violation", "rad/s", "largest rate of the constraints that are angles"});
  });
}

double Channels::value(const spec::Output& o, const std::vector<int>& mass_of,
                       relative::RelativeSystem& system, const State& s) const {
  const Compiled& m = model_;
  auto& w = system.workspace();
  const auto element = [&](int k) { return element_state(m.elements[k], std::as_const(w.elements).data()); };
  const auto motion = [&] {
    return relative::output_motion(system, m.frame_of_spec[o.item], s.q.data(), s.v.data(), s.a.data());
  };
  switch (o.kind) {
    case Measured::position:
      return motion().position[o.component] + w.origin[o.component];
    case Measured::velocity:
      return motion().velocity[o.component];
    case Measured::acceleration:
      return motion().acceleration[o.component] + m.gravity[o.component];
    case Measured::angular_velocity: {
      const auto here = motion();
      return (o.own_axes ? Vec3d(here.rotation.transpose() * here.omega) : here.omega)[o.component];
    }
    case Measured::centre_of_mass:
    case Measured::linear_momentum:
    case Measured::angular_momentum:
      return motion_of_mass(o, relative::momentum(m, w, mass_of, s.q.data(), s.v.data()), w.origin);
    case Measured::roll: {
      const Mat3d r = motion().rotation;
      return mimbre::atan2(r(2, 1), r(2, 2));
    }
    case Measured::pitch: {
      const Mat3d r = motion().rotation;
      return mimbre::atan2(-r(2, 0), mimbre::hypot(r(2, 1), r(2, 2)));
    }
    case Measured::yaw: {
      const Mat3d r = motion().rotation;
      return mimbre::atan2(r(1, 0), r(0, 0));
    }
    case Measured::joint_position:
      return joints_.coordinates(o.item, system, s).positions[o.component] + o.offset;
    case Measured::joint_velocity:
      return joints_.coordinates(o.item, system, s).rates[o.component];
    case Measured::joint_acceleration:
      return joints_.coordinates(o.item, system, s).accelerations[o.component];
    case Measured::joint_rotation:
    case Measured::joint_quaternion: {
      const int first = joint_info(m.spec().joints[o.item].type).quaternion;
      const JointCoordinates c = joints_.coordinates(o.item, system, s);
      const Quat<double> turn(c.positions[first], c.positions[first + 1], c.positions[first + 2],
                              c.positions[first + 3]);
      return o.kind == Measured::joint_quaternion ? turn[o.component]
                                                  : quaternion_log<double>(turn)[o.component];
    }
    case Measured::joint_force: {
      const JointReaction r = joints_.reaction(o.item, system, s);
      return o.component < 3 ? r.force[o.component] : r.moment[o.component - 3];
    }
    case Measured::deflection: {
      const FrameData& f = m.frames[m.frame_of_spec[o.item]];
      if (f.flexible < 0) return 0;
      const BodyData& b = m.bodies[f.body];
      const FlexibleData& flexible = m.flexible[f.flexible];
      double* const y = w.scratch.data();
      relative::copy_modes(b, s.q.data() + b.q + b.joint_positions, flexible.stride, y);
      extend(flexible, y);
      return o.direction.dot(times(f.X, y));
    }
    case Measured::displacement: {
      const auto reference =
          relative::output_motion(system, m.frame_of_spec[o.reference], s.q.data(), s.v.data(), s.a.data());
      return o.direction.dot(reference.rotation.transpose() * (motion().position - reference.position)) +
             o.offset;
    }
    case Measured::modal_amplitude: {
      const spec::Body& body = m.spec().bodies[o.item];
      if (!body.flexible) return 0;
      const BodyData& b = m.bodies[m.body_of_spec[o.item]];
      return body.flexible->user_from_modal.row(o.component)
          .dot(s.q.segment(b.q + b.joint_positions, b.modes));
    }
    case Measured::stress:
    case Measured::strain: {
      const spec::Body& body = m.spec().bodies[o.item];
      if (!body.flexible) return 0;
      const BodyData& b = m.bodies[m.body_of_spec[o.item]];
      return stress_or_strain(o, *body.flexible, s.q.segment(b.q + b.joint_positions, b.modes));
    }
    case Measured::spring_force:
      return element(o.item).force[0];
    case Measured::spring_length:
      return element(o.item).x[0];
    case Measured::tyre_force:
    case Measured::tyre_moment:
    case Measured::tyre_slip:
    case Measured::tyre_slip_angle:
    case Measured::tyre_camber:
    case Measured::tyre_deflection:
      return wheel_output(m, m.elements[m.first_tyre + o.item], o, element(m.first_tyre + o.item));
    case Measured::contact_force:
    case Measured::contact_depth:
    case Measured::contact_count: {
      const int body = o.bodies.empty() ? -1 : m.body_of_spec[static_cast<std::size_t>(o.bodies.front())];
      const ContactSum sum = contact_sum(m, w, o.item, body);
      if (o.kind == Measured::contact_depth) return sum.depth;
      if (o.kind == Measured::contact_count) return sum.count;
      return o.component < 3 ? sum.force[o.component] : o.component == 3 ? sum.normal : sum.tangential;
    }
    case Measured::signal:
      return w.signals.value[m.signals.slot_of_signal[o.item]];
    case Measured::input:
      return w.signals.value[m.signals.slot_of_input[o.item]];
    case Measured::element_force:
      return -element(m.first_other + o.item).force[o.component];
    case Measured::element_measure:
      return element(m.first_other + o.item).x[o.component];
    case Measured::element_rate:
      return element(m.first_other + o.item).v[o.component];
    case Measured::section_force: {
      const spec::Body& body = m.spec().bodies[o.item];
      if (!body.flexible) return 0;
      const auto forces = section_forces(system, *body.flexible->sections, m.body_of_spec[o.item], o.node, s);
      return o.component < 6
                 ? forces[o.component]
                 : largest_stress(body.flexible->sections->sections[static_cast<std::size_t>(o.node)],
                                  forces);
    }
  }
  return 0;
}

void Channels::mark_undetermined(const Redundancy& redundancy) {
  const auto among = [&](const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  const auto mark = [&](const Part& part, const char* note) {
    for (int k = part.first; k < part.first + part.count; ++k) {
      ChannelInfo& channel = info_[static_cast<std::size_t>(k)];
      channel.meaning += note;
      channel.determined = false;
    }
  };
  const auto mark_joint = [&](const Part& part, int joint) {
    const std::string& name = model_.spec().joints[static_cast<std::size_t>(joint)].name;
    if (among(redundancy.joints, name) || among(redundancy.nearly_joints, name))
      mark(part, ", the smallest of those that redundant constraints leave open");
  };
  for (const Part& part : parts_) {
    if (part.kind == Part::Kind::reaction) mark_joint(part, part.item);
    if (part.kind == Part::Kind::constraint) {
      const int spec = model_.constraints[static_cast<std::size_t>(part.item)].spec;
      const std::string& name = model_.spec().constraints[static_cast<std::size_t>(spec)].name;
      if (among(redundancy.constraints, name) || among(redundancy.nearly_constraints, name))
        mark(part, ", one of those that redundant constraints leave open");
    }
    if (part.kind != Part::Kind::output) continue;
    const spec::Output& o = model_.spec().outputs[static_cast<std::size_t>(part.item)];
    if (o.kind == Measured::joint_force) mark_joint(part, o.item);
  }
}

void Channels::read(const Part& part, relative::RelativeSystem& system, const State& s,
                    const EnergyBalance& e, const Statistics& statistics, double* channels) const {
  const Compiled& m = model_;
  const auto& w = system.workspace();
  const auto element = [&] { return element_state(m.elements[part.item], w.elements.data()); };
  double* to = channels + part.first;
  switch (part.kind) {
    case Part::Kind::output: {
      const auto k = static_cast<std::size_t>(part.item);
      *to = value(m.spec().outputs[k], mass_of_output_[k], system, s);
      return;
    }
    case Part::Kind::joint:
      return joints_.read_motion(part.item, system, s, to);
    case Part::Kind::reaction:
      return joints_.read_reaction(part.item, system, s, to);
    case Part::Kind::spring:
      to[0] = element().force[0];
      to[1] = element().x[0];
      return;
    case Part::Kind::tyre:
      *to = -element().force[0];
      return;
    case Part::Kind::wheel:
      return read_wheel(m, m.elements[part.item], element(), to);
    case Part::Kind::road:
      *to = *element().surroundings;
      return;
    case Part::Kind::load: {
      const ElementState<const double> l = element();
      for (const bool moment : {false, true}) {
        if (given(m.elements[part.item], moment).isZero(0)) continue;
        Vec3d::Map(to) = -l.force[0] * (moment ? l.angular_of(0) : l.linear_of(0));
        to += 3;
      }
      return;
    }
    case Part::Kind::contact: {
      const ContactSum sum = contact_sum(m, w, part.item);
      Vec3d::Map(to) = sum.force;
      to[3] = sum.normal;
      to[4] = sum.depth;
      to[5] = sum.count;
      return;
    }
    case Part::Kind::element: {
      const ElementState<const double> state = element();
      for (int c = 0; c < state.count; ++c) {
        *to++ = -state.force[c];
        *to++ = state.x[c];
      }
      return;
    }
    case Part::Kind::constraint:
      return read_constraint(m.constraints[static_cast<std::size_t>(part.item)], system, s, to);
    case Part::Kind::input:
    case Part::Kind::signal:
      *to = w.signals.value[part.item];
      return;
    case Part::Kind::event: {
      const EventRecord& event = statistics.events[static_cast<std::size_t>(part.item)];
      to[0] = static_cast<double>(event.count);
      to[1] = event.count > 0 ? event.last : -1;
      return;
    }
    case Part::Kind::energy:
      for (const EnergyTerm& term : energy_terms) *to++ = e.*term.value;
      return;
    case Part::Kind::solver:
      to[0] = statistics.iterations;
      to[1] = statistics.violations.position_violation;
      to[2] = statistics.violations.angle_violation;
      to[3] = statistics.violations.velocity_violation;
      to[4] = statistics.violations.angular_velocity_violation;
      return;
  }
}

void Channels::sample(relative::RelativeSystem& system, const State& s, const EnergyBalance& e,
                      const Statistics& statistics, ResultsRow& row) const {
  row.channels.resize(static_cast<Eigen::Index>(info_.size()));
  for (const Part& part : parts_) read(part, system, s, e, statistics, row.channels.data());
  picture(system, s, row);
}

void Channels::picture(const relative::RelativeSystem& system, const State& s, ResultsRow& row) const {
  const Compiled& m = model_;
  const auto& w = system.workspace();
  row.time = s.time;
  row.poses.resize(7, static_cast<Eigen::Index>(m.spec().bodies.size()) + (draws_ground_ ? 1 : 0));
  if (draws_ground_) row.poses.rightCols<1>() << 0, 0, 0, 1, 0, 0, 0;
  row.modes.resize(modes_);
  Eigen::Index mode = 0;
  for (std::size_t k = 0; k < m.spec().bodies.size(); ++k) {
    const BodyData& b = m.bodies[m.body_of_spec[k]];
    const auto& motion = w.bodies[m.body_of_spec[k]];
    row.poses.col(static_cast<Eigen::Index>(k)).head<3>() = motion.position + w.origin;
    row.poses.col(static_cast<Eigen::Index>(k)).tail<4>() = quaternion_of(motion.rotation);
    if (b.modes == 0) continue;
    const FlexibleData& f = m.flexible[b.flexible];
    for (int i = 0; i < b.modes; ++i) row.modes[mode + i] = s.q[b.q + b.joint_positions + i];
    extend(f, row.modes.data() + mode);
    mode += f.modes;
  }
}

std::vector<RoadDrawing> Channels::roads() const {
  std::vector<RoadDrawing> roads;
  for (const spec::Road& road : model_.spec().roads) {
    if (road.over != spec::Road::Over::distance) continue;
    const int count = 2000;
    RoadDrawing drawing{road.name, Eigen::Matrix2Xd(2, count + 1)};
    for (int k = 0; k <= count; ++k) {
      const double x = road.draw_from + (road.draw_to - road.draw_from) * k / count;
      drawing.profile.col(k) << x, road.height.value(x);
    }
    roads.push_back(std::move(drawing));
  }
  return roads;
}

}  // namespace mimbre
