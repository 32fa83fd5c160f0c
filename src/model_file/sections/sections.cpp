#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "math/elementary.h"
#include "model_file/text/builder.h"
#include "reduction/material_oddity.h"

/// Materials and beam cross-sections.
namespace mimbre::model_file {
namespace {

using std::numbers::pi;

fe::Section ring(double outer, double inner) {
  const double I = pi / 64 * (mimbre::pow(outer, 4) - mimbre::pow(inner, 4));
  fe::Section section{pi / 4 * (outer * outer - inner * inner), I, I, 2 * I};
  section.reach_y = section.reach_z = outer / 2;
  section.torsion_modulus = 2 * I / (outer / 2);
  section.round = true;
  return section;
}

/// Torsion of a rectangle: W. C. Young, Roark's Formulas, a b³ (1/3 − 0.21 b/a (1 − b⁴/12a⁴)), a ≥ b; its
/// largest shear stress, ibid., 3T/(a b²) (1 + 0.6095 r + 0.8865 r² − 1.8023 r³ + 0.91 r⁴), r = b/a.
fe::Section rectangle(double width, double height) {
  const double a = std::max(width, height), b = std::min(width, height);
  const double J = a * b * b * b * (1.0 / 3 - 0.21 * b / a * (1 - mimbre::pow(b / a, 4) / 12));
  fe::Section section{width * height, width * mimbre::pow(height, 3) / 12,
                      height * mimbre::pow(width, 3) / 12, J};
  const double r = b / a;
  section.reach_y = width / 2;
  section.reach_z = height / 2;
  section.torsion_modulus = a * b * b / (3 * (1 + r * (0.6095 + r * (0.8865 + r * (-1.8023 + r * 0.91)))));
  return section;
}

double needed(const Fields& fields, const std::string& key, const std::string& example, const Quantity& of) {
  const auto value = fields.need(key, example);
  return value ? value->positive(of).value_or(1) : 1;
}

fe::Material read_material(const Value& value) {
  const Fields fields(value, {"young", "poisson", "density"});
  fe::Material material;
  material.young = needed(fields, "young", "2.1e11", quantity::pressure);
  material.density = needed(fields, "density", "7850", quantity::density);
  material.poisson = 0.3;
  if (const auto poisson = fields.need("poisson", "0.3")) {
    const auto number = poisson->number();
    if (number && (*number <= -1 || *number >= 0.5))
      poisson->error(fmt::format("{} is not between -1 and 0.5", *number));
    material.poisson = number.value_or(0.3);
  }
  return material;
}

/// Once for a template, however many instances it has.
void warn_of_oddity(Builder& builder, const Value& value, const fe::Material& material) {
  const std::string odd = fe::oddity(material);
  const Mark& at = value.mark();
  const bool reported =
      std::any_of(builder.warnings.begin(), builder.warnings.end(), [&](const Diagnostic& d) {
        return d.mark.file == at.file && d.mark.line == at.line && d.mark.column == at.column;
      });
  if (!odd.empty() && !reported)
    builder.warnings.push_back(
        {at, fmt::format("{}: {}; numbers without a unit are in Pa and kg/m³", value.what(), odd)});
}

/// Along the element's y and z; of the sections whose shape is not known, for Timoshenko's theory.
void read_shear_areas(const Fields& fields, fe::Section& section) {
  const auto areas = fields.get("shear_areas");
  if (!areas) return;
  const auto parts = areas->list();
  if (parts.size() != 2)
    return areas->error("two areas are needed, along the element's y and along its z: [8.5e-5, 8.5e-5]");
  section.shear_y = parts[0].positive(quantity::area).value_or(1);
  section.shear_z = parts[1].positive(quantity::area).value_or(1);
}

/// What stress is reckoned from, of the sections whose shape is not known.
void read_fibres(const Fields& fields, fe::Section& section) {
  const auto outermost = fields.get("outermost"), modulus = fields.get("torsion_modulus");
  if (!outermost && !modulus) return;
  if (!outermost)
    return modulus->error("goes with 'outermost: [y, z]', how far the outermost fibres are from the axis");
  if (!modulus)
    return outermost->error(
        "goes with 'torsion_modulus', torque over the largest shear stress, m³; of a thin open section J "
        "over its largest thickness");
  const auto parts = outermost->list();
  if (parts.size() != 2)
    return outermost->error("two distances are needed, along the element's y and along its z: [0.05, 0.1]");
  // I = ∫ d² dA is at most that of an area that lies all in its outermost fibres.
  const auto reach = [&](const Value& part, double second_moment, const char* name) {
    const double distance = part.positive(quantity::length).value_or(1),
                 least = std::sqrt(second_moment / section.area);
    if (distance < least * (1 - 1e-9))
      part.error(
          fmt::format("{} is nearer to the axis than √({}/area) = {:.4g} m, where the fibres are on average",
                      distance, name, least));
    return distance;
  };
  section.reach_y = reach(parts[0], section.Iz, "Iz");
  section.reach_z = reach(parts[1], section.Iy, "Iy");
  section.torsion_modulus = modulus->positive(quantity::section_modulus).value_or(1);
}

NamedSection read_section(const Value& value) {
  const bool general = value.is_map() && !value.tree().find("type");
  NamedSection named;
  if (general) {
    const Fields fields(value, {"area", "Iy", "Iz", "J", "shear_areas", "outermost", "torsion_modulus"});
    named.section = {needed(fields, "area", "1e-4", quantity::area),
                     needed(fields, "Iy", "1e-9", quantity::second_moment),
                     needed(fields, "Iz", "1e-9", quantity::second_moment),
                     needed(fields, "J", "2e-9", quantity::second_moment)};
    read_shear_areas(fields, named.section);
    read_fibres(fields, named.section);
    return named;
  }
  const Fields any(value, {"type", "diameter", "inner_diameter", "width", "height", "shear_areas"});
  const auto type = any.need("type", "round");
  const auto choice = type ? type->choice({"round", "tube", "rectangle"}) : std::nullopt;
  if (!choice) return named;
  if (*choice == 0) {
    const Fields fields(value, {"type", "diameter", "shear_areas"});
    named = {ring(needed(fields, "diameter", "0.02", quantity::length), 0), fe::round_shear(0)};
  } else if (*choice == 1) {
    const Fields fields(value, {"type", "diameter", "inner_diameter", "shear_areas"});
    const double outer = needed(fields, "diameter", "0.03", quantity::length);
    const double inner = needed(fields, "inner_diameter", "0.024", quantity::length);
    if (inner >= outer && fields.has("diameter") && fields.has("inner_diameter"))
      fields.error(fmt::format("inner_diameter {} is not less than diameter {}", inner, outer));
    named = {ring(outer, inner), fe::round_shear(inner / outer)};
  } else {
    const Fields fields(value, {"type", "width", "height", "shear_areas"});
    named = {rectangle(needed(fields, "width", "0.05", quantity::length),
                       needed(fields, "height", "0.002", quantity::length)),
             fe::rectangle_shear()};
  }
  read_shear_areas(any, named.section);
  return named;
}

}  // namespace

void read_materials_and_sections(Builder& builder, Part& part) {
  const auto read = [&](const std::string& key, const std::string& kind, auto&& one) {
    const auto section = part.section(key);
    if (!section) return;
    if (!section->is_map()) return section->error(fmt::format("names with their {}s are needed", kind));
    for (const auto& entry : section->tree().entries)
      if (check_name(part.reading, entry.key, entry.mark, kind))
        one(entry.key,
            Value(part.reading, *entry.value, fmt::format("{} '{}'", kind, part.full_name(entry.key))));
  };
  // Inside a template those of where it is written are known too.
  if (part.home) {
    part.materials = part.home->materials;
    part.sections = part.home->sections;
  }
  read("materials", "material", [&](const std::string& n, const Value& v) {
    part.materials[n] = read_material(v);
    warn_of_oddity(builder, v, part.materials[n]);
  });
  read("sections", "section",
       [&](const std::string& n, const Value& v) { part.sections[n] = read_section(v); });
}

}  // namespace mimbre::model_file
