#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model_file/builder.h"

/// Materials and beam cross-sections.
namespace mimbre::model_file {
namespace {

using std::numbers::pi;

fe::Section ring(double outer, double inner) {
  const double I = pi / 64 * (std::pow(outer, 4) - std::pow(inner, 4));
  return {pi / 4 * (outer * outer - inner * inner), I, I, 2 * I};
}

/// Torsion of a rectangle: W. C. Young, Roark's Formulas, a b³ (1/3 − 0.21 b/a (1 − b⁴/12a⁴)), a ≥ b.
fe::Section rectangle(double width, double height) {
  const double a = std::max(width, height), b = std::min(width, height);
  const double J = a * b * b * b * (1.0 / 3 - 0.21 * b / a * (1 - std::pow(b / a, 4) / 12));
  return {width * height, width * std::pow(height, 3) / 12, height * std::pow(width, 3) / 12, J};
}

double needed(const Fields& fields, const std::string& key, const std::string& example) {
  const auto value = fields.need(key, example);
  return value ? value->positive().value_or(1) : 1;
}

fe::Material read_material(const Value& value) {
  const Fields fields(value, {"young", "poisson", "density"});
  fe::Material material;
  material.young = needed(fields, "young", "2.1e11");
  material.density = needed(fields, "density", "7850");
  material.poisson = 0.3;
  if (const auto poisson = fields.need("poisson", "0.3")) {
    const auto number = poisson->number();
    if (number && (*number <= -1 || *number >= 0.5))
      poisson->error(fmt::format("{} is not between -1 and 0.5", *number));
    material.poisson = number.value_or(0.3);
  }
  return material;
}

fe::Section read_section(const Value& value) {
  const bool general = value.is_map() && !value.tree().find("type");
  if (general) {
    const Fields fields(value, {"area", "Iy", "Iz", "J"});
    return {needed(fields, "area", "1e-4"), needed(fields, "Iy", "1e-9"), needed(fields, "Iz", "1e-9"),
            needed(fields, "J", "2e-9")};
  }
  const Fields any(value, {"type", "diameter", "inner_diameter", "width", "height"});
  const auto type = any.need("type", "round");
  const auto choice = type ? type->choice({"round", "tube", "rectangle"}) : std::nullopt;
  if (!choice) return {};
  if (*choice == 0) {
    const Fields fields(value, {"type", "diameter"});
    return ring(needed(fields, "diameter", "0.02"), 0);
  }
  if (*choice == 1) {
    const Fields fields(value, {"type", "diameter", "inner_diameter"});
    const double outer = needed(fields, "diameter", "0.03");
    const double inner = needed(fields, "inner_diameter", "0.024");
    if (inner >= outer && fields.has("diameter") && fields.has("inner_diameter"))
      fields.error(fmt::format("inner_diameter {} is not less than diameter {}", inner, outer));
    return ring(outer, inner);
  }
  const Fields fields(value, {"type", "width", "height"});
  return rectangle(needed(fields, "width", "0.05"), needed(fields, "height", "0.002"));
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
  // Inside a template the model's are known too.
  if (!part.instance.empty()) {
    part.materials = builder.parts.front().materials;
    part.sections = builder.parts.front().sections;
  }
  read("materials", "material",
       [&](const std::string& n, const Value& v) { part.materials[n] = read_material(v); });
  read("sections", "section",
       [&](const std::string& n, const Value& v) { part.sections[n] = read_section(v); });
}

}  // namespace mimbre::model_file
