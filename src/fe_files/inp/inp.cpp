#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "fe_files/inp/inp_model.h"
#include "fe_files/mesh_formats.h"
#include "fe_files/text.h"

// Keywords: CalculiX CrunchiX user's manual 2.20 and Abaqus Keywords Guide.

namespace mimbre::fe {

int InpModel::element_set(const std::string& name) {
  const auto [place, is_new] =
      element_set_by_name.emplace(lower(name), static_cast<int>(element_sets.size()));
  if (is_new) element_sets.push_back({name, {}});
  return place->second;
}

const InpElementSet& InpModel::known_element_set(const std::string& name, const Mark& mark) const {
  const auto found = element_set_by_name.find(lower(name));
  if (found != element_set_by_name.end()) return element_sets[static_cast<std::size_t>(found->second)];
  std::vector<std::string> names;
  for (const InpElementSet& set : element_sets) names.push_back(set.name);
  throw InputError(mark,
                   fmt::format("there is no element set '{}'{}", shown(name), did_you_mean(name, names)));
}

void InpModel::warn(const std::string& key, Mark mark, std::string message) {
  if (warned.insert(key).second) warnings.push_back({std::move(mark), std::move(message)});
}

void add_members(const std::vector<int>& more, std::size_t universe, std::vector<int>& members) {
  members.insert(members.end(), more.begin(), more.end());
  if (members.size() < 2 * universe + 1000) return;
  std::sort(members.begin(), members.end());
  members.erase(std::unique(members.begin(), members.end()), members.end());
}

namespace {

constexpr const char* kKnownTypes =
    "C3D4, C3D10, C3D8, C3D20, C3D6, C3D15 (solids), S3, S4, S6, S8 (shells), B31 and B32 (beams)";

struct Named {
  std::string_view name;
  InpType type;
};
using InpKind = InpType::Kind;
constexpr Named kNamedTypes[] = {
    {"C3D4", {InpKind::element, ElementType::tet4, 4}},
    {"C3D10", {InpKind::element, ElementType::tet10, 10}},
    {"C3D8", {InpKind::element, ElementType::hex8, 8}},
    {"C3D20", {InpKind::element, ElementType::hex20, 20}},
    {"C3D6", {InpKind::element, ElementType::wedge6, 6}},
    {"C3D15", {InpKind::element, ElementType::wedge15, 15}},
    {"S3", {InpKind::element, ElementType::tri3, 3}},
    {"S4", {InpKind::element, ElementType::quad4, 4}},
    {"S6", {InpKind::element, ElementType::tri6, 6}},
    {"S8", {InpKind::element, ElementType::quad8, 8}},
    {"B31", {InpKind::beam, ElementType::tet4, 2}},
    {"B32", {InpKind::beam, ElementType::tet4, 3}},
    {"T3D2", {InpKind::boundary_only, ElementType::tet4, 2}},
    {"T3D3", {InpKind::boundary_only, ElementType::tet4, 3}},
};
constexpr Named kPointTypes[] = {
    {"MASS", {InpKind::mass, ElementType::tet4, 1}},
    {"ROTARYI", {InpKind::inertia, ElementType::tet4, 1}},
    {"SPRINGA", {InpKind::spring_along, ElementType::tet4, 2}},
    {"SPRING2", {InpKind::spring_between, ElementType::tet4, 2}},
};

/// Plane elements: meshers write the surfaces of a solid so.
bool is_plane(std::string_view name) {
  for (const std::string_view head : {"CPS", "CPE", "CAX", "M3D", "SFM3D"})
    if (name.starts_with(head)) return true;
  return false;
}

std::optional<InpType> find_type(const std::string& name) {
  for (const Named& type : kPointTypes)
    if (name == type.name) return type.type;
  for (const Named& type : kNamedTypes) {
    if (!name.starts_with(type.name)) continue;
    const std::string_view suffix = std::string_view(name).substr(type.name.size());
    const bool variant = suffix.find_first_not_of("IRHMS") == std::string_view::npos;
    if (!suffix.empty() && (!variant || type.type.kind == InpKind::boundary_only)) continue;
    InpType found = type.type;
    found.reduced = suffix.find('R') != std::string_view::npos;
    return found;
  }
  if (is_plane(name)) {
    const std::size_t digit = name.find_first_of("0123456789", name.starts_with("M3D")     ? 3
                                                               : name.starts_with("SFM3D") ? 5
                                                                                           : 0);
    const auto nodes = to_integer(std::string_view(name).substr(std::min(digit, name.size()), 1));
    if (nodes && *nodes >= 3)
      return InpType{InpKind::boundary_only, ElementType::tri3, static_cast<int>(*nodes)};
  }
  return std::nullopt;
}

std::int64_t label_of(std::string_view field, const char* what, const TextFile& file) {
  const auto label = to_integer(field);
  if (!label || *label <= 0)
    file.fail(field.empty() ? fmt::format("{} is missing", what)
                            : fmt::format("'{}' is no {} (a whole number from 1)", shown(field), what));
  return *label;
}

const std::string& needed(const InpKeyword& keyword, const char* parameter, const char* example) {
  const std::string* value = keyword.find(parameter);
  if (!value || value->empty())
    throw InputError(keyword.mark, fmt::format("*{} needs {}=, for example *{}, {}", keyword.name, parameter,
                                               keyword.name, example));
  return *value;
}

void read_nodes(InpModel& model, const InpKeyword& keyword) {
  const std::string* system = keyword.find("SYSTEM");
  if (system && lower(*system) != "r")
    throw InputError(keyword.mark,
                     "nodes in cylindrical or spherical coordinates are not read; write them in x, y, z");
  if (keyword.find("INPUT"))
    throw InputError(keyword.mark, "*NODE with INPUT= is not read; write *INCLUDE, INPUT=... below *NODE");
  const std::string* set_name = keyword.find("NSET");
  std::vector<int>* set = set_name ? &model.node_sets[*set_name] : nullptr;
  std::string_view line;
  while (model.lines.next_data(line)) {
    const TextFile& file = model.lines.file();
    const std::int64_t label = label_of(next_field(line), "node number", file);
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    for (int i = 0; i < 3 && !line.empty(); ++i) {
      const std::string_view field = next_field(line);
      if (field.empty()) continue;  // zero
      const auto value = to_real(field);
      if (!value) file.fail(fmt::format("'{}' is no coordinate of node {}", shown(field), label));
      position(i) = *value;
    }
    const int index = model.nodes.add(label, position, file);
    if (set) set->push_back(index);
  }
}

void read_elements(InpModel& model, const InpKeyword& keyword) {
  std::string name = needed(keyword, "TYPE", "TYPE=C3D10, ELSET=body");
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  if (keyword.find("INPUT"))
    throw InputError(keyword.mark,
                     "*ELEMENT with INPUT= is not read; write *INCLUDE, INPUT=... below *ELEMENT");
  const std::optional<InpType> type = find_type(name);
  const bool point = name.starts_with("MASS") || name.starts_with("ROTARY") || name.starts_with("SPRING") ||
                     name.starts_with("DASHPOT") || name.starts_with("CONN") || name.starts_with("GAP") ||
                     name.starts_with("D");
  if (!type && !point)
    throw InputError(keyword.mark,
                     fmt::format("elements {} are not read; there are {}", shown(name), kKnownTypes));
  const std::string* set_name = keyword.find("ELSET");
  const int home = set_name ? model.element_set(*set_name) : -1;
  if (!type) {
    std::string why;
    if (name == "SPRING1") why = ": a spring to the ground would hold the body; add it in the mechanism";
    model.warn("type " + name, keyword.mark, fmt::format("elements {} are left out{}", shown(name), why));
    return;
  }
  if (type->kind == InpKind::boundary_only)
    model.warn("type " + name, keyword.mark,
               fmt::format("elements {} are not part of the body; they only make node sets", name));
  const int type_index = static_cast<int>(model.types.size());
  model.types.push_back(*type);
  std::string_view line;
  while (model.lines.next_data(line)) {
    TextFile& file = model.lines.file();
    InpElement element;
    element.label = label_of(next_field(line), "element number", file);
    element.type = type_index;
    element.home = home;
    element.first = model.element_nodes.size();
    for (int i = 0; i < type->nodes; ++i) {
      // The nodes of large elements go on in the next line.
      while (trimmed(line).empty())
        if (!model.lines.next_data(line))
          file.fail(
              fmt::format("element {} has {} of the {} nodes of {}", element.label, i, type->nodes, name));
      const TextFile& here = model.lines.file();
      const std::int64_t node = label_of(next_field(line), "node of the element", here);
      model.element_nodes.push_back(model.nodes.at(node, here, "element", element.label));
    }
    if (!trimmed(line).empty())
      file.fail(fmt::format("element {} has more than the {} nodes of {}", element.label, type->nodes, name));
    const int index = static_cast<int>(model.elements.size());
    if (!model.element_by_label.emplace(element.label, index).second)
      model.lines.file().fail(fmt::format("element {} is there already", element.label));
    model.elements.push_back(element);
    if (home >= 0) model.element_sets[static_cast<std::size_t>(home)].elements.push_back(index);
  }
}

/// Calls `one(field)` for every field of the data lines, or `range(first, last, step)` with GENERATE.
template <class One, class Range>
void for_members(InpModel& model, const InpKeyword& keyword, One&& one, Range&& range) {
  std::string_view line;
  const bool generate = keyword.find("GENERATE") != nullptr;
  while (model.lines.next_data(line)) {
    const TextFile& file = model.lines.file();
    if (!generate) {
      while (!line.empty())
        if (const std::string_view field = next_field(line); !field.empty()) one(field, file);
      continue;
    }
    const std::int64_t first = label_of(next_field(line), "first number", file);
    const std::int64_t last = label_of(next_field(line), "last number", file);
    if (last < first) file.fail(fmt::format("the last number, {}, is below the first, {}", last, first));
    const std::string_view field = next_field(line);
    const std::int64_t step = field.empty() ? 1 : label_of(field, "step", file);
    range(first, last, step, file);
  }
}

void read_node_set(InpModel& model, const InpKeyword& keyword) {
  const std::string name = needed(keyword, "NSET", "NSET=left");
  std::vector<int> members;
  if (const std::string* elements = keyword.find("ELSET")) {
    for (const int index : model.known_element_set(*elements, keyword.mark).elements) {
      const InpElement& element = model.elements[static_cast<std::size_t>(index)];
      for (int i = 0; i < model.types[static_cast<std::size_t>(element.type)].nodes; ++i)
        members.push_back(model.element_nodes[element.first + static_cast<std::size_t>(i)]);
    }
  }
  const auto add_label = [&](std::int64_t label, const TextFile& file) {
    const int index = model.nodes.find(label);
    if (index >= 0)
      members.push_back(index);
    else
      model.warn("missing node in " + name, file.mark(),
                 fmt::format("node {} of the set {} is not there", label, shown(name)));
  };
  for_members(
      model, keyword,
      [&](std::string_view field, const TextFile& file) {
        if (const auto label = to_integer(field)) return add_label(*label, file);
        const std::vector<int>* other = model.node_sets.find(std::string(field));
        if (!other) file.fail(fmt::format("there is no node set '{}'", shown(field)));
        add_members(*other, static_cast<std::size_t>(model.nodes.size()), members);
      },
      [&](std::int64_t first, std::int64_t last, std::int64_t step, const TextFile& file) {
        // A range may be far longer than the list of nodes.
        if ((last - first) / step > static_cast<std::int64_t>(model.nodes.size())) {
          for (int i = 0; i < model.nodes.size(); ++i) {
            const std::int64_t label = model.nodes.label(i);
            if (label >= first && label <= last && (label - first) % step == 0) members.push_back(i);
          }
          return;
        }
        for (std::int64_t label = first; label <= last;) {
          add_label(label, file);
          if (last - label < step) break;
          label += step;
        }
      });
  add_members(members, static_cast<std::size_t>(model.nodes.size()), model.node_sets[name]);
}

void read_element_set(InpModel& model, const InpKeyword& keyword) {
  const std::string name = needed(keyword, "ELSET", "ELSET=body");
  std::vector<int> members;
  // In contrast to nodes, what is not there may be an element that is left out.
  const auto add_label = [&](std::int64_t label) {
    const auto found = model.element_by_label.find(label);
    if (found != model.element_by_label.end()) members.push_back(found->second);
    return found != model.element_by_label.end();
  };
  const auto warn_missing = [&](std::int64_t label, const TextFile& file) {
    model.warn("missing in " + name, file.mark(),
               fmt::format("element {} of the set {} is not there", label, shown(name)));
  };
  for_members(
      model, keyword,
      [&](std::string_view field, const TextFile& file) {
        if (const auto label = to_integer(field)) {
          if (!add_label(*label)) warn_missing(*label, file);
          return;
        }
        const std::vector<int>& other = model.known_element_set(std::string(field), file.mark()).elements;
        add_members(other, model.elements.size(), members);
      },
      [&](std::int64_t first, std::int64_t last, std::int64_t step, const TextFile& file) {
        // A range may be far longer than the list of elements.
        if ((last - first) / step > static_cast<std::int64_t>(model.elements.size())) {
          for (std::size_t i = 0; i < model.elements.size(); ++i) {
            const std::int64_t label = model.elements[i].label;
            if (label >= first && label <= last && (label - first) % step == 0)
              members.push_back(static_cast<int>(i));
          }
          return;
        }
        for (std::int64_t label = first; label <= last;) {
          if (!add_label(label)) warn_missing(label, file);
          if (last - label < step) break;
          label += step;
        }
      });
  add_members(members, model.elements.size(),
              model.element_sets[static_cast<std::size_t>(model.element_set(name))].elements);
}

/// Nothing of the body: what to print, tables of loads, headings.
bool is_silent_keyword(const std::string& name) {
  for (const std::string_view known : {"HEADING",
                                       "PREPRINT",
                                       "RESTART",
                                       "NODE PRINT",
                                       "NODE FILE",
                                       "NODE OUTPUT",
                                       "EL PRINT",
                                       "EL FILE",
                                       "ELEMENT OUTPUT",
                                       "OUTPUT",
                                       "CONTACT FILE",
                                       "ASSEMBLY",
                                       "END ASSEMBLY",
                                       "END PART",
                                       "END INSTANCE",
                                       "AMPLITUDE",
                                       "PHYSICAL CONSTANTS",
                                       "INITIAL CONDITIONS",
                                       "EXPANSION",
                                       "CONDUCTIVITY",
                                       "SPECIFIC HEAT",
                                       "HOURGLASS STIFFNESS",
                                       "SECTION CONTROLS",
                                       "SURFACE INTERACTION",
                                       "FRICTION",
                                       "SURFACE BEHAVIOR"})
    if (name == known) return true;
  return false;
}

void skip_steps(InpModel& model) {
  InpKeyword keyword;
  while (model.lines.next_keyword(keyword))
    if (keyword.name == "END STEP") return;
}

void read_keyword(InpModel& model, const InpKeyword& keyword, bool& part) {
  if (keyword.name == "NODE") return read_nodes(model, keyword);
  if (keyword.name == "ELEMENT") return read_elements(model, keyword);
  if (keyword.name == "NSET") return read_node_set(model, keyword);
  if (keyword.name == "ELSET") return read_element_set(model, keyword);
  if (keyword.name == "SURFACE") return read_inp_surface(model, keyword);
  if (read_inp_material(model, keyword) || read_inp_section(model, keyword) ||
      read_inp_point_property(model, keyword) || read_inp_constraint(model, keyword))
    return;
  if (keyword.name == "STEP") return skip_steps(model);
  if (keyword.name == "PART") {
    if (part)
      throw InputError(keyword.mark,
                       "a second part; node numbers repeat from part to part: write a file without parts "
                       "(Abaqus/CAE: model attribute 'Do not use parts and assemblies in input files')");
    part = true;
    return;
  }
  if (keyword.name == "INSTANCE") {
    std::string_view line;
    if (model.lines.next_data(line))
      model.warn("INSTANCE", keyword.mark,
                 "the position of the instance is left out: nodes stay in the axes of the part");
    return;
  }
  for (const std::string_view generator : {"NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM"})
    if (keyword.name == generator)
      throw InputError(keyword.mark,
                       fmt::format("*{} is not read; write the finished mesh: nodes and elements one by one",
                                   keyword.name));
  if (keyword.name == "MEMBRANE SECTION")
    throw InputError(keyword.mark, "membranes are not read, and the body would lack them");
  if (!is_silent_keyword(keyword.name))
    model.warn("keyword " + keyword.name, keyword.mark, fmt::format("*{} is left out", shown(keyword.name)));
}

}  // namespace

ImportedMesh parse_inp(std::unique_ptr<TextFile> file, const std::string& folder, bool includes) {
  InpLines lines(std::move(file), folder, includes);
  InpModel model(lines);
  InpKeyword keyword;
  bool part = false;
  while (lines.next_keyword(keyword)) read_keyword(model, keyword, part);
  if (model.nodes.size() == 0) lines.file().fail("has no nodes (*NODE)");
  return finish_inp(model);
}

const MeshFormat inp_format{
    .ending = ".inp",
    .program = "CalculiX, Abaqus",
    .help =
        "CalculiX, Abaqus: mesh, materials, sections; the matrices of .sti, .mas and .dof\n"
        "                        of the same name where they lie beside it",
    .parse = [](std::unique_ptr<TextFile> file, const std::string& folder) {
      return parse_inp(std::move(file), folder, true);
    }};

}  // namespace mimbre::fe
