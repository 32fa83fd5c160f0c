#include "simulation/describe/names.h"

#include <fmt/format.h>

namespace mimbre {
namespace {

std::string relative_name(const Compiled& m, int coordinate) {
  for (const BodyData& b : m.bodies)
    if (coordinate >= b.v && coordinate < b.v + b.size()) {
      const int k = coordinate - b.v;
      if (k < b.joint_velocities) return fmt::format("joint '{}'", m.spec().joints[b.joint_spec].name);
      return fmt::format("mode {} of body '{}'", k - b.joint_velocities + 1, m.spec().bodies[b.spec].name);
    }
  return "the model";
}

std::string natural_name(const natural::NaturalSystem& system, int coordinate) {
  const int body = coordinate < 0 ? -1 : system.body_of(coordinate);
  if (body < 0) return "the model";
  return fmt::format("body '{}'", system.model().spec().bodies[system.model().bodies[body].spec].name);
}

}  // namespace

std::string coordinate_name(const Compiled& m, const natural::NaturalSystem* natural, int coordinate) {
  return natural ? natural_name(*natural, coordinate) : relative_name(m, coordinate);
}

const ConstraintData* constraint_of(const Compiled& m, const natural::NaturalSystem* natural, int equation) {
  for (std::size_t k = 0; k < m.constraints.size(); ++k) {
    const ConstraintData& c = m.constraints[k];
    const int first = natural ? natural->layout().constraints[k].first_equation : c.first_equation;
    if (equation >= first && equation < first + c.count) return &c;
  }
  return nullptr;
}

std::string equation_name(const Compiled& m, const natural::NaturalSystem* natural, int equation) {
  const auto joint = [&](int spec) { return fmt::format("joint '{}'", m.spec().joints[spec].name); };
  if (const ConstraintData* c = constraint_of(m, natural, equation))
    return fmt::format("constraint '{}'", m.spec().constraints[c->spec].name);
  const auto within = [&](int first, int count) { return equation >= first && equation < first + count; };
  if (natural) {
    const natural::Layout& l = natural->layout();
    for (std::size_t b = 0; b < l.bodies.size(); ++b)
      if (within(l.bodies[b].first_equation, static_cast<int>(l.bodies[b].rigidity.size())))
        return fmt::format("the rigidity of body '{}'", m.spec().bodies[m.bodies[b].spec].name);
    for (const natural::Joint& j : l.joints)
      if (within(j.first_equation, j.count)) return joint(j.spec);
    if (equation >= l.first_drive)
      return "the drive of " + joint(m.drives[equation - l.first_drive].joint_spec);
  } else {
    for (const LoopData& loop : m.loops)
      if (within(loop.first_equation, loop.count)) return joint(loop.joint_spec);
    for (const DriveData& d : m.drives)
      if (equation == d.equation) return "the drive of " + joint(d.joint_spec);
  }
  return "the constraints";
}

std::string place_name(const Compiled& m, const EnergyMeter::Place& place) {
  switch (place.kind) {
    case EnergyMeter::Place::Kind::element:
      return element_name(m, m.elements[place.index]);
    case EnergyMeter::Place::Kind::body:
      return fmt::format("body '{}'", m.spec().bodies[m.bodies[place.index].spec].name);
    case EnergyMeter::Place::Kind::none:
      break;
  }
  return "the joints";
}

}  // namespace mimbre
