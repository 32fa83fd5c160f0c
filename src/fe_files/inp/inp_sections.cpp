#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <tuple>

#include "fe_files/inp/inp_model.h"
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

using SectionKind = InpSection::Kind;

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
  section.kind = SectionKind::beam;
  std::string shape = lower(needed(keyword, "SECTION"));
  for (const char* name : {"rect", "circ"})  // also written out
    if (shape.starts_with(name)) shape = name;
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
  // Of the nodes from the axis, in sides of the section.
  const double width = shape == "rect" || shape == "box" || (shape == "circ" && sizes.size() > 1)
                           ? sizes[0]
                           : 2 * sizes[0],
               height = width == sizes[0] ? sizes[1] : width;
  int direction = 0;
  for (const char* offset : {"OFFSET1", "OFFSET2"}) {
    if (const std::string* given = keyword.find(offset)) {
      const auto value = to_real(*given);
      if (!value) throw InputError(keyword.mark, fmt::format("{}={} is no number", offset, shown(*given)));
      section.beam_offset[direction] = -*value * (direction == 0 ? width : height);
    }
    ++direction;
  }
  section.first_axis = -Eigen::Vector3d::UnitZ();  // Abaqus, CalculiX: when no direction is given
  if (!model.lines.next_data(line)) return;
  for (double& x : section.first_axis) {
    const std::string_view field = next_field(line);
    const auto value = to_real(field);
    if (!value) model.lines.file().fail(fmt::format("'{}' is no part of a direction", shown(field)));
    x = *value;
  }
}

/// Lines "thickness, points across it, material, orientation" of layers.
void read_plies(InpModel& model, const InpKeyword& keyword, InpSection& section) {
  std::string_view line;
  while (model.lines.next_data(line)) {
    const std::string_view thickness = next_field(line);
    next_field(line);
    InpPly ply;
    ply.thickness = to_real(thickness).value_or(0);
    ply.material = next_field(line);
    ply.orientation = next_field(line);
    if (!(ply.thickness > 0) || ply.material.empty())
      model.lines.file().fail(
          "a layer needs a positive thickness, and a material behind the number of points");
    if (const auto angle = to_real(ply.orientation)) {
      if (*angle != 0)
        model.lines.file().fail("the direction of a layer by its angle is not read; name an *ORIENTATION");
      ply.orientation.clear();
    }
    if (ply.orientation.empty()) ply.orientation = section.orientation;
    section.thickness += ply.thickness;
    section.plies.push_back(std::move(ply));
  }
  if (section.plies.empty()) throw InputError(keyword.mark, "COMPOSITE needs a line for each layer");
}

}  // namespace

bool read_inp_section(InpModel& model, const InpKeyword& keyword) {
  InpSection section;
  section.mark = keyword.mark;
  if (keyword.name == "SHELL SECTION") {
    section.kind = SectionKind::shell;
  } else if (keyword.name == "BEAM SECTION" || keyword.name == "BEAM GENERAL SECTION") {
    section.kind = SectionKind::beam;
  } else if (keyword.name != "SOLID SECTION") {
    return false;
  }
  section.element_set = needed(keyword, "ELSET");
  if (const std::string* orientation = keyword.find("ORIENTATION")) section.orientation = *orientation;
  const bool layers = section.kind == SectionKind::shell && keyword.find("COMPOSITE");
  if (layers)
    read_plies(model, keyword, section);
  else
    section.material = needed(keyword, "MATERIAL");
  if (section.kind == SectionKind::shell) {
    if (!layers) section.thickness = inp_numbers(model, keyword, 1, "the thickness")[0];
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
  if (section.kind == SectionKind::beam) read_beam_section(model, keyword, section);
  model.sections.push_back(std::move(section));
  return true;
}

namespace {

int find_material(const InpModel& model, const std::string& name, const Mark& mark) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < model.materials.size(); ++i) {
    if (lower(model.materials[i].name) == lower(name)) return static_cast<int>(i);
    names.push_back(model.materials[i].name);
  }
  throw InputError(mark, fmt::format("there is no material '{}'{}", shown(name), did_you_mean(name, names)));
}

int find_orientation(const InpModel& model, const std::string& name, const Mark& mark) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < model.orientations.size(); ++i) {
    if (lower(model.orientations[i].name) == lower(name)) return static_cast<int>(i);
    names.push_back(model.orientations[i].name);
  }
  throw InputError(mark,
                   fmt::format("there is no orientation '{}'{}", shown(name), did_you_mean(name, names)));
}

const char* name_of(SectionKind kind) {
  return kind == SectionKind::solid   ? "*SOLID SECTION"
         : kind == SectionKind::shell ? "*SHELL SECTION"
                                      : "*BEAM SECTION";
}

/// Meshers write faces and edges of solids as plane elements and trusses, that a section may take with the
/// solids; with a section of their own they are meant.
void require_read(const InpModel& model, const InpSection& section, const std::vector<int>& elements) {
  const auto left_out = [&](int index) {
    const InpElement& element = model.elements[static_cast<std::size_t>(index)];
    return model.types[static_cast<std::size_t>(element.type)].kind == InpType::Kind::boundary_only;
  };
  if (elements.empty() || !std::all_of(elements.begin(), elements.end(), left_out)) return;
  throw InputError(
      section.mark,
      fmt::format("the set {} has a section and holds nothing but trusses, membranes or plane elements, "
                  "which are not read: the body would lack them",
                  shown(section.element_set)));
}

void assign_sections(InpModel& model) {
  for (std::size_t s = 0; s < model.sections.size(); ++s) {
    const InpSection& section = model.sections[s];
    const std::vector<int>& elements = model.known_element_set(section.element_set, section.mark).elements;
    require_read(model, section, elements);
    for (const int index : elements) {
      InpElement& element = model.elements[static_cast<std::size_t>(index)];
      const InpType& type = model.types[static_cast<std::size_t>(element.type)];
      if (type.kind != InpType::Kind::element && type.kind != InpType::Kind::beam) continue;
      const SectionKind right = type.kind == InpType::Kind::beam ? SectionKind::beam
                                : is_shell(type.type)            ? SectionKind::shell
                                                                 : SectionKind::solid;
      if (right != section.kind)
        throw InputError(section.mark, fmt::format("element {} of the set {} needs a {}", element.label,
                                                   shown(section.element_set), name_of(right)));
      element.section = static_cast<int>(s);
    }
  }
}

/// Refuses a beam without length and one along the direction that its section is to have across.
void check_beam(const InpModel& model, const InpElement& element, const InpSection& section,
                const std::array<int, 2>& nodes) {
  const Eigen::Vector3d axis = model.nodes.position(nodes[1]) - model.nodes.position(nodes[0]);
  if (!(axis.norm() > 0))
    throw InputError(section.mark, fmt::format("element {} of the set {} has no length", element.label,
                                               shown(section.element_set)));
  const double along = axis.cross(section.first_axis).norm() / (axis.norm() * section.first_axis.norm());
  if (along < 1e-8)
    throw InputError(section.mark, fmt::format("element {} of the set {} lies along the direction 1 of its "
                                               "section; give another one in the last line of the section",
                                               element.label, shown(section.element_set)));
}

/// One beam between neighbours of its nodes: a quadratic beam is two that bend as cubics, exact in statics
/// where it is straight.
void add_beams(const InpModel& model, const InpElement& element, const InpSection* section, int material,
               SolidMesh& mesh) {
  const InpType& type = model.types[static_cast<std::size_t>(element.type)];
  const auto first = model.element_nodes.begin() + static_cast<std::ptrdiff_t>(element.first);
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
  for (int k = 0; k + 1 < type.nodes; ++k) {
    beam.nodes = {first[k], first[k + 1]};
    if (section) check_beam(model, element, *section, beam.nodes);
    mesh.beams.push_back(beam);
  }
}

/// Sheets of the section: one, or one for each layer, on the same nodes.
struct Sheet {
  int material = -1;
  double thickness = 0, offset = 0;
  int orientation = -1;
};

std::vector<Sheet> sheets_of(const InpModel& model, const InpSection& section) {
  const auto orientation = [&](const std::string& name) {
    return name.empty() ? -1 : find_orientation(model, name, section.mark);
  };
  if (section.plies.empty())
    return {{find_material(model, section.material, section.mark), section.thickness, section.offset,
             orientation(section.orientation)}};
  std::vector<Sheet> sheets;
  double bottom = section.offset - section.thickness / 2;
  for (const InpPly& ply : section.plies) {
    sheets.push_back({find_material(model, ply.material, section.mark), ply.thickness,
                      bottom + ply.thickness / 2, orientation(ply.orientation)});
    bottom += ply.thickness;
  }
  return sheets;
}

/// The axes of beams beside their nodes. Where beams meet nearly in line their directions are means.
void offset_beams(const std::vector<Eigen::Vector2d>& offsets, SolidMesh& mesh) {
  using Directions = Eigen::Matrix<double, 3, 2>;  ///< 1 and 2 of a section
  constexpr double in_line = 0.94;                 // the cosine of 20°
  std::vector<Directions> directions(mesh.beams.size(), Directions::Zero());
  std::map<int, std::vector<Directions>> at_nodes;
  for (std::size_t k = 0; k < mesh.beams.size(); ++k) {
    const BeamElement& beam = mesh.beams[k];
    if (offsets[k].isZero(0)) continue;
    const Eigen::Vector3d along = mesh.nodes.col(beam.nodes[1]) - mesh.nodes.col(beam.nodes[0]);
    directions[k].col(1) = along.cross(beam.y_direction).normalized();
    directions[k].col(0) = directions[k].col(1).cross(along).normalized();
    for (const int node : beam.nodes) at_nodes[node].push_back(directions[k]);
  }
  for (std::size_t k = 0; k < mesh.beams.size(); ++k) {
    if (offsets[k].isZero(0)) continue;
    for (std::size_t end = 0; end < 2; ++end)
      for (int d = 0; d < 2; ++d) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (const Directions& other : at_nodes.at(mesh.beams[k].nodes[end]))
          if (other.col(d).dot(directions[k].col(d)) > in_line) sum += other.col(d);
        mesh.beams[k].offsets[end] += offsets[k][d] * sum.normalized();
      }
  }
}

/// A sheet's group of elements without elements.
ElementGroup group_of(const InpType& type, const Sheet& sheet, const std::string& name) {
  ElementGroup group;
  group.type = type.type;
  group.name = name;
  group.material = sheet.material;
  group.thickness = sheet.thickness;
  group.offset = sheet.offset;
  group.reduced_integration = type.reduced;
  return group;
}

/// Warns of elements without a section, and of materials without elasticity or density.
void warn_of_missing(InpModel& model, const std::vector<std::vector<Sheet>>& sheets,
                     const std::vector<char>& in_use, std::int64_t without, const Mark& end) {
  for (std::size_t k = 0; k < sheets.size(); ++k)
    for (const Sheet& sheet : sheets[k]) {
      const NamedMaterial& named = model.materials[static_cast<std::size_t>(sheet.material)];
      if (in_use[k] && named.material.young <= 0 && !named.elastic)
        model.warn("elastic " + named.name, model.sections[k].mark,
                   fmt::format("material '{}' {}", shown(named.name), no_elasticity));
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
}

/// Names of element sets also stand for the nodes of their elements.
void add_node_sets_of_elements(InpModel& model) {
  for (const InpElementSet& elements : model.element_sets) {
    if (model.node_sets.find(elements.name)) continue;
    std::vector<int>& nodes = model.node_sets[elements.name];
    for (const int index : elements.elements) {
      const InpElement& element = model.elements[static_cast<std::size_t>(index)];
      const auto first = model.element_nodes.begin() + static_cast<std::ptrdiff_t>(element.first);
      nodes.insert(nodes.end(), first, first + model.types[static_cast<std::size_t>(element.type)].nodes);
    }
  }
}

}  // namespace

ImportedMesh finish_inp(InpModel& model) {
  assign_sections(model);
  ImportedMesh result;
  SolidMesh& mesh = result.mesh;
  const Mark end = model.lines.file().mark();
  const std::vector<Sheet> unsaid{Sheet{}};
  std::vector<std::vector<Sheet>> sheets;
  for (const InpSection& section : model.sections) {
    sheets.push_back(sheets_of(model, section));
    if (section.plies.size() > 1)
      model.warn("layers", section.mark,
                 "layers are sheets on the same nodes; stress in them has no meaning");
  }
  std::map<std::tuple<ElementType, bool, int, int>, int> groups;  ///< the first of a section's sheets
  std::vector<Eigen::Vector2d> beam_offsets;
  std::int64_t without = 0;
  std::vector<char> in_use(model.sections.size(), 0);
  for (const InpElement& element : model.elements) {
    const InpType& type = model.types[static_cast<std::size_t>(element.type)];
    if (type.kind != InpType::Kind::element && type.kind != InpType::Kind::beam) continue;
    if (element.section < 0)
      ++without;
    else
      in_use[static_cast<std::size_t>(element.section)] = 1;
    const InpSection* section =
        element.section < 0 ? nullptr : &model.sections[static_cast<std::size_t>(element.section)];
    const std::vector<Sheet>& own = section ? sheets[static_cast<std::size_t>(element.section)] : unsaid;
    if (type.kind == InpType::Kind::beam) {
      add_beams(model, element, section, own.front().material, mesh);
      beam_offsets.resize(mesh.beams.size(), section ? section->beam_offset : Eigen::Vector2d::Zero());
      continue;
    }
    const int home = section ? -1 : element.home;
    const auto [place, is_new] = groups.emplace(std::tuple(type.type, type.reduced, element.section, home),
                                                static_cast<int>(mesh.groups.size()));
    const std::string name = section    ? section->element_set
                             : home < 0 ? std::string()
                                        : model.element_sets[static_cast<std::size_t>(home)].name;
    for (std::size_t k = 0; is_new && k < own.size(); ++k)
      mesh.groups.push_back(group_of(type, own[k], name));
    const auto first = model.element_nodes.begin() + static_cast<std::ptrdiff_t>(element.first);
    for (std::size_t k = 0; k < own.size(); ++k) {
      ElementGroup& group = mesh.groups[static_cast<std::size_t>(place->second) + k];
      group.nodes.insert(group.nodes.end(), first, first + type.nodes);
      group.labels.push_back(element.label);
      if (own[k].orientation >= 0) group.orientations.push_back(own[k].orientation);
    }
  }
  warn_of_missing(model, sheets, in_use, without, end);
  add_node_sets_of_elements(model);
  model.node_sets.move_into(mesh);
  model.nodes.move_into(mesh);
  for (const InpOrientation& named : model.orientations) mesh.orientations.push_back(named.orientation);
  offset_beams(beam_offsets, mesh);
  mesh.equations = std::move(model.equations);
  mesh.rigid_elements = std::move(model.rigid_elements);
  mesh.mean_elements = std::move(model.mean_elements);
  finish_inp_points(model, mesh);
  check_inp_transforms(model, mesh);
  finish_inp_ties(model, mesh);
  finish_inp_normals(mesh);
  mesh.materials = std::move(model.materials);
  result.warnings = std::move(model.warnings);
  return result;
}

}  // namespace mimbre::fe
