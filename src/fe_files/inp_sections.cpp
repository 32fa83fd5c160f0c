#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <tuple>

#include "fe_files/inp_model.h"
#include "fe_files/text.h"

namespace mimbre::fe {

const std::string& needed(const InpKeyword& keyword, const char* parameter) {
  const std::string* value = keyword.find(parameter);
  if (!value || value->empty())
    throw InputError(keyword.mark, fmt::format("*{} needs {}=", keyword.name, parameter));
  return *value;
}

std::vector<double> inp_numbers(InpModel& model, const InpKeyword& keyword, int count, const char* what) {
  std::string_view line;
  std::vector<double> values;
  for (int i = 0; i < count; ++i) {
    while (trimmed(line).empty())
      if (!model.lines.next_data(line))
        throw InputError(keyword.mark, fmt::format("*{} needs {}", keyword.name, what));
    const std::string_view field = next_field(line);
    const auto value = to_real(field);
    if (!value)
      model.lines.file().fail(
          fmt::format("'{}' stands where *{} needs {}", shown(field), keyword.name, what));
    values.push_back(*value);
  }
  return values;
}

namespace {

using Kind = InpSection::Kind;

/// As in the model file: W. C. Young, Roark's Formulas, for the torsion of a rectangle.
Section rectangle(double first, double second) {
  const double a = std::max(first, second), b = std::min(first, second);
  const double J = a * b * b * b * (1.0 / 3 - 0.21 * b / a * (1 - std::pow(b / a, 4) / 12));
  return {first * second, first * std::pow(second, 3) / 12, second * std::pow(first, 3) / 12, J};
}

/// Ellipse of the diameters `first` and `second`, with a similar hole of `inner` times them.
Section ellipse(double first, double second, double inner) {
  const double a = first / 2, b = second / 2, left = 1 - std::pow(inner, 4), pi = std::numbers::pi;
  Section section;
  section.area = pi * a * b * (1 - inner * inner);
  section.Iy = pi / 4 * a * b * b * b * left;
  section.Iz = pi / 4 * b * a * a * a * left;
  section.J = pi * std::pow(a * b, 3) / (a * a + b * b) * left;
  section.round = true;
  return section;
}

/// Of thin walls; a along 1, b along 2.
Section box(double a, double b, const std::array<double, 4>& t) {
  // Walls t[0] and t[2] are normal to 1, t[1] and t[3] normal to 2.
  const double inner_a = a - t[0] - t[2], inner_b = b - t[1] - t[3];
  Section section;
  section.area = a * b - inner_a * inner_b;
  section.Iy = (a * std::pow(b, 3) - inner_a * std::pow(inner_b, 3)) / 12;
  section.Iz = (b * std::pow(a, 3) - inner_b * std::pow(inner_a, 3)) / 12;
  const double along_a = a - (t[0] + t[2]) / 2, along_b = b - (t[1] + t[3]) / 2;
  section.J = 4 * std::pow(along_a * along_b, 2) /
              (along_b / t[0] + along_b / t[2] + along_a / t[1] + along_a / t[3]);
  // Webs along the shear force.
  section.shear_y = along_a * (t[1] + t[3]);
  section.shear_z = along_b * (t[0] + t[2]);
  return section;
}

void read_beam_section(InpModel& model, const InpKeyword& keyword, InpSection& section) {
  section.kind = Kind::beam;
  const std::string shape = lower(needed(keyword, "SECTION"));
  for (const char* offset : {"OFFSET1", "OFFSET2"})
    if (const std::string* value = keyword.find(offset); value && to_real(*value).value_or(1) != 0)
      throw InputError(keyword.mark, fmt::format("{} is not read; put the nodes on the beam's axis", offset));
  std::string_view line;
  if (!model.lines.next_data(line))
    throw InputError(keyword.mark, "*BEAM SECTION needs a line with the sizes of its section");
  std::vector<double> sizes;
  while (!trimmed(line).empty()) {
    const std::string_view field = next_field(line);
    const auto value = to_real(field);
    if (!value || !(*value > 0))
      model.lines.file().fail(fmt::format("'{}' is no size of a section: a positive number", shown(field)));
    sizes.push_back(*value);
  }
  const auto need = [&](std::size_t least, const char* what) {
    if (sizes.size() < least) model.lines.file().fail(fmt::format("SECTION={} needs {}", shown(shape), what));
  };
  if (shape == "rect") {
    need(2, "the sides of the rectangle along 1 and 2");
    section.beam = rectangle(sizes[0], sizes[1]);
    section.shear = rectangle_shear();
  } else if (shape == "circ") {
    // CalculiX takes two diameters, Abaqus the radius.
    need(1, "two diameters (CalculiX) or a radius (Abaqus)");
    section.beam = sizes.size() > 1 ? ellipse(sizes[0], sizes[1], 0) : ellipse(2 * sizes[0], 2 * sizes[0], 0);
    section.shear = round_shear(0);
  } else if (shape == "pipe") {
    need(2, "the outer radius and the wall's thickness");
    if (!(sizes[1] < sizes[0])) model.lines.file().fail("the wall of a pipe must be thinner than its radius");
    const double inner = 1 - sizes[1] / sizes[0];
    section.beam = ellipse(2 * sizes[0], 2 * sizes[0], inner);
    section.shear = round_shear(inner);
  } else if (shape == "box") {
    need(6, "its sides along 1 and 2 and the thicknesses of its four walls");
    if (!(sizes[2] + sizes[4] < sizes[0] && sizes[3] + sizes[5] < sizes[1]))
      model.lines.file().fail("the walls of a box must be thinner than it is wide");
    if (sizes[2] != sizes[4] || sizes[3] != sizes[5])
      model.lines.file().fail("opposite walls of a box must be equal: else its axis lies off its middle");
    section.beam = box(sizes[0], sizes[1], {sizes[2], sizes[3], sizes[4], sizes[5]});
  } else {
    throw InputError(keyword.mark, fmt::format("beam sections '{}' are not read; there are RECT, CIRC, PIPE "
                                               "and BOX",
                                               shown(shape)));
  }
  section.first_axis = -Eigen::Vector3d::UnitZ();  // Abaqus, CalculiX: when no direction is said
  if (!model.lines.next_data(line)) return;
  for (double& x : section.first_axis) {
    const std::string_view field = next_field(line);
    const auto value = to_real(field);
    if (!value) model.lines.file().fail(fmt::format("'{}' is no part of a direction", shown(field)));
    x = *value;
  }
}

}  // namespace

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
  if (const std::string* orientation = keyword.find("ORIENTATION")) section.orientation = *orientation;
  if (section.kind == Kind::shell) {
    section.thickness = inp_numbers(model, keyword, 1, "the thickness")[0];
    if (!(section.thickness > 0)) model.lines.file().fail("a thickness must be positive");
    if (const std::string* offset = keyword.find("OFFSET")) {
      // Of the nodes from the middle surface, in thicknesses; Abaqus: also the name of a side.
      const std::string side = lower(*offset);
      const auto value = side == "spos" ? 0.5 : side == "sneg" ? -0.5 : to_real(*offset);
      if (!value)
        throw InputError(keyword.mark, fmt::format("OFFSET={} is no number, SPOS or SNEG", shown(*offset)));
      section.offset = -*value * section.thickness;
    }
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

int find_orientation(const InpModel& model, const InpSection& section) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < model.orientations.size(); ++i) {
    if (lower(model.orientations[i].name) == lower(section.orientation)) return static_cast<int>(i);
    names.push_back(model.orientations[i].name);
  }
  throw InputError(section.mark, fmt::format("there is no orientation '{}'{}", shown(section.orientation),
                                             did_you_mean(section.orientation, names)));
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
      if (type.kind != InpType::Kind::element && type.kind != InpType::Kind::beam) continue;
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
  std::map<std::tuple<ElementType, bool, int, int>, int> groups;
  std::int64_t without = 0;
  for (const InpElement& element : model.elements) {
    const InpType& type = model.types[static_cast<std::size_t>(element.type)];
    if (type.kind != InpType::Kind::element && type.kind != InpType::Kind::beam) continue;
    if (element.section < 0) ++without;
    const InpSection* section =
        element.section < 0 ? nullptr : &model.sections[static_cast<std::size_t>(element.section)];
    const int material = section ? materials[static_cast<std::size_t>(element.section)] : -1;
    const auto first = model.element_nodes.begin() + static_cast<std::ptrdiff_t>(element.first);
    if (type.kind == InpType::Kind::beam) {
      BeamElement beam;
      beam.theory = BeamTheory::timoshenko;
      if (section) {
        beam.section = section->beam;
        beam.y_direction = section->first_axis;
        beam.material = model.materials[static_cast<std::size_t>(material)].material;
        if (section->shear.known())
          beam.section.shear_y = beam.section.shear_z =
              section->shear.at(beam.material.poisson) * beam.section.area;
      }
      // A quadratic beam is two that bend as cubics, exact in statics where it is straight.
      for (int k = 0; k + 1 < type.nodes; ++k) {
        beam.nodes = {first[k], first[k + 1]};
        mesh.beams.push_back(beam);
      }
      continue;
    }
    const int home = section ? -1 : element.home;
    const auto [place, is_new] = groups.emplace(std::tuple(type.type, type.reduced, element.section, home),
                                                static_cast<int>(mesh.groups.size()));
    if (is_new) {
      ElementGroup group;
      group.type = type.type;
      group.name = section    ? section->element_set
                   : home < 0 ? std::string()
                              : model.element_sets[static_cast<std::size_t>(home)].name;
      group.material = material;
      group.thickness = section ? section->thickness : 0;
      group.offset = section ? section->offset : 0;
      group.reduced_integration = type.reduced;
      mesh.groups.push_back(std::move(group));
    }
    ElementGroup& group = mesh.groups[static_cast<std::size_t>(place->second)];
    group.nodes.insert(group.nodes.end(), first, first + type.nodes);
    group.labels.push_back(element.label);
    if (section && !section->orientation.empty())
      group.orientations.push_back(find_orientation(model, *section));
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
  for (const InpOrientation& named : model.orientations) mesh.orientations.push_back(named.orientation);
  mesh.equations = std::move(model.equations);
  mesh.rigid_elements = std::move(model.rigid_elements);
  mesh.mean_elements = std::move(model.mean_elements);
  finish_inp_points(model, mesh);
  finish_inp_ties(model, mesh);
  mesh.materials = std::move(model.materials);
  result.warnings = std::move(model.warnings);
  return result;
}

}  // namespace mimbre::fe
