#include "tyre_files/units.h"

#include <fmt/format.h>

#include <map>
#include <string>

#include "fe_files/text.h"

namespace mimbre::tyre_files {
namespace {

using Names = std::map<std::string, double>;

const Names lengths{{"meter", 1},     {"metre", 1},         {"m", 1},       {"millimeter", 1e-3},
                    {"mm", 1e-3},     {"centimeter", 1e-2}, {"cm", 1e-2},   {"kilometer", 1e3},
                    {"km", 1e3},      {"inch", 0.0254},     {"in", 0.0254}, {"foot", 0.3048},
                    {"feet", 0.3048}, {"ft", 0.3048}};
const Names forces{{"newton", 1},
                   {"n", 1},
                   {"kilonewton", 1e3},
                   {"knewton", 1e3},
                   {"kn", 1e3},
                   {"pound_force", 4.4482216152605},
                   {"lbf", 4.4482216152605},
                   {"kg_force", 9.80665},
                   {"kgf", 9.80665}};
const Names times{{"second", 1}, {"sec", 1},     {"s", 1},      {"millisecond", 1e-3},
                  {"ms", 1e-3},  {"minute", 60}, {"hour", 3600}};
const Names pressures{{"pascal", 1}, {"pa", 1},    {"kpascal", 1e3},          {"kpa", 1e3},
                      {"mpa", 1e6},  {"bar", 1e5}, {"psi", 6894.757293168361}};
const Names angles{{"radian", 1}, {"radians", 1}, {"rad", 1}};

std::string listed(const Names& names) {
  std::string text;
  for (const auto& [name, value] : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

/// The first property of each kind of unit.
using Given = std::map<std::string, const Property*>;

void take(const Property& property, const Names& names, Given& given, double& unit,
          std::vector<Diagnostic>& errors) {
  const auto found = names.find(fe::lower(property.value));
  if (found == names.end()) {
    errors.push_back({property.mark, fmt::format("{} cannot be '{}'; known are {}", property.key,
                                                 fe::shown(property.value), listed(names))});
    return;
  }
  const auto [before, first] = given.emplace(property.key, &property);
  if (!first && unit != found->second)
    errors.push_back({property.mark, fmt::format("{} is '{}' here and '{}' in line {}", property.key,
                                                 fe::shown(property.value), fe::shown(before->second->value),
                                                 before->second->mark.line)});
  unit = found->second;
}

}  // namespace

double Units::of(forces::magic::Unit unit) const {
  using forces::magic::Unit;
  switch (unit) {
    case Unit::none:
      return 1;
    case Unit::length:
      return length;
    case Unit::force:
      return force;
    case Unit::speed:
      return length / time;
    case Unit::pressure:
      return pressure;
    case Unit::stiffness:
      return force / length;
    case Unit::damping:
      return force * time / length;
  }
  return 1;
}

Units read_units(const std::vector<Property>& properties, std::vector<Diagnostic>& errors) {
  Units units;
  double radian = 1;
  Given given;
  for (const Property& property : properties) {
    if (property.section != "UNITS") continue;
    if (property.key == "LENGTH") take(property, lengths, given, units.length, errors);
    if (property.key == "FORCE") take(property, forces, given, units.force, errors);
    if (property.key == "TIME") take(property, times, given, units.time, errors);
    if (property.key == "PRESSURE") take(property, pressures, given, units.pressure, errors);
    if (property.key == "ANGLE") take(property, angles, given, radian, errors);
  }
  return units;
}

}  // namespace mimbre::tyre_files
