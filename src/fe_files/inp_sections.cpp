#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "fe_files/inp_model.h"
#include "fe_files/text.h"

namespace mimbre::fe {

namespace {

using Kind = InpSection::Kind;

const std::string& needed(const InpKeyword& keyword, const char* parameter) {
  const std::string* value = keyword.find(parameter);
  if (!value || value->empty())
    throw InputError(keyword.mark, fmt::format("*{} needs {}=", keyword.name, parameter));
  return *value;
}

/// The first line of data, which must have `count` numbers in front.
std::vector<double> numbers(InpModel& model, const InpKeyword& keyword, int count, const char* what) {
  std::string_view line;
  if (!model.lines.next_data(line))
    throw InputError(keyword.mark, fmt::format("*{} needs a line with {}", keyword.name, what));
  std::vector<double> values;
  for (int i = 0; i < count; ++i) {
    const std::string_view field = next_field(line);
    const auto value = to_real(field);
    if (!value)
      model.lines.file().fail(
          fmt::format("'{}' stands where *{} needs {}", shown(field), keyword.name, what));
    values.push_back(*value);
  }
  return values;
}

Material& current_material(InpModel& model, const InpKeyword& keyword) {
  if (model.materials.empty())
    throw InputError(keyword.mark, fmt::format("*{} stands before every *MATERIAL", keyword.name));
  return model.materials.back().material;
}

/// As in the model file: W. C. Young, Roark's Formulas, for the torsion of a rectangle.
Section rectangle(double first, double second) {
  const double a = std::max(first, second), b = std::min(first, second);
  const double J = a * b * b * b * (1.0 / 3 - 0.21 * b / a * (1 - std::pow(b / a, 4) / 12));
  return {first * second, first * std::pow(second, 3) / 12, second * std::pow(first, 3) / 12, J};
}

void read_beam_section(InpModel& model, const InpKeyword& keyword, InpSection& section) {
  section.kind = Kind::beam;
  const std::string shape = lower(needed(keyword, "SECTION"));
  // CalculiX takes two thicknesses of a circle, Abaqus its radius: only the rectangle is the same in both.
  if (shape != "rect")
    throw InputError(keyword.mark,
                     fmt::format("beam sections '{}' are not read; there is SECTION=RECT", shown(shape)));
  const std::vector<double> sides = numbers(model, keyword, 2, "the sides of the rectangle along 1 and 2");
  if (!(sides[0] > 0 && sides[1] > 0)) model.lines.file().fail("the sides of a section must be positive");
  section.beam = rectangle(sides[0], sides[1]);
  section.first_axis = -Eigen::Vector3d::UnitZ();  // Abaqus, CalculiX: when no direction is said
  std::string_view line;
  if (!model.lines.next_data(line)) return;
  for (double& x : section.first_axis) {
    const std::string_view field = next_field(line);
    const auto value = to_real(field);
    if (!value) model.lines.file().fail(fmt::format("'{}' is no part of a direction", shown(field)));
    x = *value;
  }
}

}  // namespace

bool read_inp_material(InpModel& model, const InpKeyword& keyword) {
  if (keyword.name == "MATERIAL") {
    model.materials.push_back({needed(keyword, "NAME"), {}});
    return true;
  }
  if (keyword.name == "DENSITY") {
    Material& material = current_material(model, keyword);
    material.density = numbers(model, keyword, 1, "the density")[0];
    if (!(material.density > 0)) model.lines.file().fail("a density must be positive");
    return true;
  }
  if (keyword.name != "ELASTIC") return false;
  Material& material = current_material(model, keyword);
  const std::string* type = keyword.find("TYPE");
  if (type && lower(*type).substr(0, 3) != "iso")
    throw InputError(keyword.mark,
                     fmt::format("*ELASTIC, TYPE={} is not read; materials are isotropic", shown(*type)));
  const std::vector<double> values = numbers(model, keyword, 2, "Young's modulus and Poisson's ratio");
  if (!(values[0] > 0)) model.lines.file().fail("Young's modulus must be positive");
  if (!(values[1] > -1 && values[1] < 0.5))
    model.lines.file().fail(fmt::format("Poisson's ratio {} is not between -1 and 0.5", values[1]));
  material.young = values[0];
  material.poisson = values[1];
  std::string_view line;
  if (model.lines.next_data(line))
    model.warn("elastic", model.lines.file().mark(),
               "only the first line of *ELASTIC counts: no temperatures");
  return true;
}

bool read_inp_section(InpModel& model, const InpKeyword& keyword) {
  InpSection section;
  section.mark = keyword.mark;
  if (keyword.name == "SHELL SECTION") {
    section.kind = Kind::shell;
  } else if (keyword.name == "BEAM SECTION") {
    section.kind = Kind::beam;
  } else if (keyword.name != "SOLID SECTION") {
    return false;
  }
  section.element_set = needed(keyword, "ELSET");
  if (keyword.find("COMPOSITE"))
    throw InputError(keyword.mark, "layers (COMPOSITE) are not read; shells have one isotropic material");
  section.material = needed(keyword, "MATERIAL");
  if (keyword.find("ORIENTATION"))
    model.warn("orientation", keyword.mark, "ORIENTATION is left out: materials are isotropic");
  if (const std::string* offset = keyword.find("OFFSET"); offset && to_real(*offset).value_or(1) != 0)
    throw InputError(keyword.mark, "OFFSET is not read; put the nodes on the middle surface");
  if (section.kind == Kind::shell) {
    section.thickness = numbers(model, keyword, 1, "the thickness")[0];
    if (!(section.thickness > 0)) model.lines.file().fail("a thickness must be positive");
  }
  if (section.kind == Kind::beam) read_beam_section(model, keyword, section);
  model.sections.push_back(std::move(section));
  return true;
}

namespace {

int find_material(const InpModel& model, const InpSection& section) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < model.materials.size(); ++i) {
    if (lower(model.materials[i].name) == lower(section.material)) return static_cast<int>(i);
    names.push_back(model.materials[i].name);
  }
  throw InputError(section.mark, fmt::format("there is no material '{}'{}", shown(section.material),
                                             did_you_mean(section.material, names)));
}

const char* name_of(Kind kind) {
  return kind == Kind::solid ? "*SOLID SECTION" : kind == Kind::shell ? "*SHELL SECTION" : "*BEAM SECTION";
}

void assign_sections(InpModel& model) {
  for (std::size_t s = 0; s < model.sections.size(); ++s) {
    const InpSection& section = model.sections[s];
    for (const int index : model.known_element_set(section.element_set, section.mark).elements) {
      InpElement& element = model.elements[static_cast<std::size_t>(index)];
      const InpType& type = model.types[static_cast<std::size_t>(element.type)];
      if (type.kind == InpType::Kind::boundary_only) continue;
      const Kind right = type.kind == InpType::Kind::beam ? Kind::beam
                         : is_shell(type.type)            ? Kind::shell
                                                          : Kind::solid;
      if (right != section.kind)
        throw InputError(section.mark, fmt::format("element {} of the set {} needs a {}", element.label,
                                                   shown(section.element_set), name_of(right)));
      element.section = static_cast<int>(s);
    }
  }
}

}  // namespace

ImportedMesh finish_inp(InpModel& model) {
  assign_sections(model);
  ImportedMesh result;
  SolidMesh& mesh = result.mesh;
  const Mark end = model.lines.file().mark();
  std::vector<int> materials;
  for (const InpSection& section : model.sections) materials.push_back(find_material(model, section));
  std::map<std::tuple<ElementType, int, int>, int> groups;
  std::int64_t without = 0;
  for (const InpElement& element : model.elements) {
    const InpType& type = model.types[static_cast<std::size_t>(element.type)];
    if (type.kind == InpType::Kind::boundary_only) continue;
    if (element.section < 0) ++without;
    const InpSection* section =
        element.section < 0 ? nullptr : &model.sections[static_cast<std::size_t>(element.section)];
    const int material = section ? materials[static_cast<std::size_t>(element.section)] : -1;
    const auto first = model.element_nodes.begin() + static_cast<std::ptrdiff_t>(element.first);
    if (type.kind == InpType::Kind::beam) {
      BeamElement beam;
      beam.nodes = {first[0], first[1]};
      if (section) {
        beam.section = section->beam;
        beam.y_direction = section->first_axis;
        beam.material = model.materials[static_cast<std::size_t>(material)].material;
      }
      mesh.beams.push_back(beam);
      continue;
    }
    const int home = section ? -1 : element.home;
    const auto [place, is_new] =
        groups.emplace(std::tuple(type.type, element.section, home), static_cast<int>(mesh.groups.size()));
    if (is_new) {
      ElementGroup group;
      group.type = type.type;
      group.name = section    ? section->element_set
                   : home < 0 ? std::string()
                              : model.element_sets[static_cast<std::size_t>(home)].name;
      group.material = material;
      group.thickness = section ? section->thickness : 0;
      mesh.groups.push_back(std::move(group));
    }
    ElementGroup& group = mesh.groups[static_cast<std::size_t>(place->second)];
    group.nodes.insert(group.nodes.end(), first, first + type.nodes);
    group.labels.push_back(element.label);
  }
  if (without > 0 && !model.sections.empty())
    model.warn("without section", end,
               fmt::format("{} elements have no section and so no material", without));
  for (const NamedMaterial& named : model.materials)
    for (const auto& [value, keyword] :
         {std::pair(named.material.young, "*ELASTIC"), std::pair(named.material.density, "*DENSITY")})
      if (value <= 0)
        model.warn("material " + named.name, end,
                   fmt::format("material {} has no {}", shown(named.name), keyword));
  for (const InpElementSet& elements : model.element_sets) {
    if (model.node_sets.find(elements.name)) continue;
    std::vector<int>& nodes = model.node_sets[elements.name];
    for (const int index : elements.elements) {
      const InpElement& element = model.elements[static_cast<std::size_t>(index)];
      const auto first = model.element_nodes.begin() + static_cast<std::ptrdiff_t>(element.first);
      nodes.insert(nodes.end(), first, first + model.types[static_cast<std::size_t>(element.type)].nodes);
    }
  }
  model.node_sets.move_into(mesh);
  model.nodes.move_into(mesh);
  mesh.materials = std::move(model.materials);
  result.warnings = std::move(model.warnings);
  return result;
}

}  // namespace mimbre::fe
