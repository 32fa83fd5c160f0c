#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "fe_files/mesh_builder.h"
#include "fe_files/mesh_formats.h"
#include "fe_files/text.h"

// Format: Universal File Formats (SDRC I-DEAS; Siemens PLM), data sets 15, 164, 781, 2411, 2412 and the
// permanent groups; order of the nodes of parabolic elements: corners and the nodes between them in turn.

namespace mimbre::fe {
namespace {

/// One of the elements of data set 2412. Those without `ours` can only be parts of sets.
struct UnvType {
  int code, dimension, nodes;
  const char* name;
  std::optional<ElementType> ours = {};
};

constexpr UnvType unv_types[] = {
    {11, 1, 2, "rod"},
    {21, 1, 2, "beam"},
    {22, 1, 3, "beam with 3 nodes"},
    {23, 1, 3, "beam with 3 nodes"},
    {24, 1, 3, "beam with 3 nodes"},
    {41, 2, 3, "triangle of plane stress", ElementType::tri3},
    {42, 2, 6, "triangle of plane stress", ElementType::tri6},
    {44, 2, 4, "quadrangle of plane stress", ElementType::quad4},
    {45, 2, 8, "quadrangle of plane stress", ElementType::quad8},
    {51, 2, 3, "triangle of plane strain", ElementType::tri3},
    {52, 2, 6, "triangle of plane strain", ElementType::tri6},
    {54, 2, 4, "quadrangle of plane strain", ElementType::quad4},
    {55, 2, 8, "quadrangle of plane strain", ElementType::quad8},
    {91, 2, 3, "triangle", ElementType::tri3},
    {92, 2, 6, "triangle", ElementType::tri6},
    {94, 2, 4, "quadrangle", ElementType::quad4},
    {95, 2, 8, "quadrangle", ElementType::quad8},
    {111, 3, 4, "tetrahedron", ElementType::tet4},
    {112, 3, 6, "wedge", ElementType::wedge6},
    {113, 3, 15, "wedge", ElementType::wedge15},
    {115, 3, 8, "brick", ElementType::hex8},
    {116, 3, 20, "brick", ElementType::hex20},
    {118, 3, 10, "tetrahedron", ElementType::tet10},
    {136, 0, 2, "spring"},
    {161, 0, 1, "mass"},
};

/// Where each of our nodes (Abaqus numbering) is in the file's element.
std::vector<int> order_of_nodes(ElementType type) {
  switch (type) {
    case ElementType::tri6:
      return {0, 2, 4, 1, 3, 5};
    case ElementType::quad8:
      return {0, 2, 4, 6, 1, 3, 5, 7};
    case ElementType::tet10:
      return {0, 2, 4, 9, 1, 3, 5, 6, 7, 8};
    case ElementType::wedge15:
      return {0, 2, 4, 9, 11, 13, 1, 3, 5, 10, 12, 14, 6, 7, 8};
    case ElementType::hex20:
      return {0, 2, 4, 6, 12, 14, 16, 18, 1, 3, 5, 7, 13, 15, 17, 19, 8, 9, 10, 11};
    default: {
      std::vector<int> same(static_cast<std::size_t>(node_count(type)));
      for (std::size_t i = 0; i < same.size(); ++i) same[i] = static_cast<int>(i);
      return same;
    }
  }
}

/// Numbers of a permanent group by its data set: of an entity, of which two are its kind and label.
int numbers_of_entity(std::int64_t set) {
  switch (set) {
    case 2435:
    case 2452:
    case 2467:
    case 2477:
      return 4;
    case 2417:
    case 2429:
    case 2430:
    case 2432:
      return 2;
    default:
      return 0;
  }
}

class UnvReader {
 public:
  explicit UnvReader(TextFile& file) : file_(file) {}

  ImportedMesh read() {
    std::string_view line;
    bool any = false;
    while (file_.next(line)) {
      if (trimmed(line).empty()) continue;
      if (trimmed(line) != "-1")
        file_.fail(any ? fmt::format("'{}' is outside of all data sets, which stand between lines of -1",
                                     shown(line))
                       : std::string("is no universal file: the first line must be -1"));
      any = true;
      line = file_.expect("the head of a data set");
      read_set(file_.integer(line, "number of a data set"));
    }
    return finish();
  }

 private:
  struct Element {
    std::int64_t label = 0, property = 0;
    const UnvType* type = nullptr;
    std::size_t first = 0;  ///< in element_nodes_
    std::string group = {};
  };

  TextFile& file_;
  NodeTable nodes_;
  NodeSets sets_;
  std::vector<Element> elements_;
  std::vector<int> element_nodes_;
  std::map<std::int64_t, std::size_t> element_by_label_;
  std::vector<Diagnostic> warnings_;

  /// False at the set's end.
  bool next_record(std::string_view& line) {
    line = file_.expect("a data set, which a line of -1 ends");
    return trimmed(line) != "-1";
  }
  /// The next number of a list that goes on over lines.
  std::int64_t next_integer(std::string_view& line, const char* what) {
    while (trimmed(line).empty()) line = file_.expect(what);
    return file_.integer(line, what);
  }

  void read_set(std::int64_t number) {
    if (number == 2411 || number == 781) return read_nodes(true);
    if (number == 15) return read_nodes(false);
    if (number == 2412) return read_elements();
    if (number == 164) return read_units();
    if (const int count = numbers_of_entity(number); count > 0) return read_groups(count);
    for (std::string_view line; next_record(line);) {
    }
  }

  /// `split`: the coordinates have a line of their own.
  void read_nodes(bool split) {
    for (std::string_view line; next_record(line);) {
      const std::int64_t label = file_.integer(line, "node number");
      for (int k = 0; k < 3; ++k) file_.integer(line, "system or colour of the node");
      if (split) line = file_.expect("the coordinates of a node");
      Eigen::Vector3d position;
      for (double& x : position) x = file_.real(line, "coordinate");
      nodes_.add(label, position, file_);
    }
  }

  void read_elements() {
    for (std::string_view line; next_record(line);) {
      Element element;
      element.label = file_.integer(line, "element number");
      const std::int64_t code = file_.integer(line, "kind of the element");
      element.property = file_.integer(line, "property of the element");
      for (int k = 0; k < 2; ++k) file_.integer(line, "material or colour of the element");
      const std::int64_t count = file_.integer(line, "count of nodes");
      for (const UnvType& type : unv_types)
        if (type.code == code) element.type = &type;
      if (!element.type)
        file_.fail(fmt::format("element {} is of the kind {}, which is not read", element.label, code));
      if (count != element.type->nodes)
        file_.fail(fmt::format("element {} has {} nodes; a {} of the kind {} has {}", element.label, count,
                               element.type->name, code, element.type->nodes));
      if (element.type->dimension == 1) file_.expect("the orientation of a beam");
      element.first = element_nodes_.size();
      line = {};
      for (std::int64_t k = 0; k < count; ++k)
        element_nodes_.push_back(
            nodes_.at(next_integer(line, "node of the element"), file_, "element", element.label));
      if (!element_by_label_.emplace(element.label, elements_.size()).second)
        file_.fail(fmt::format("element {} is there already", element.label));
      elements_.push_back(element);
    }
  }

  /// A group becomes a set of nodes; elements of the first one that lists them are a group of elements.
  void read_groups(int numbers) {
    for (std::string_view line; next_record(line);) {
      const std::int64_t number = file_.integer(line, "group number");
      for (int k = 0; k < 6; ++k) file_.integer(line, "set of the group");
      const std::int64_t count = file_.integer(line, "count of the group's members");
      std::string name(trimmed(file_.expect("the name of a group")));
      if (name.empty()) name = std::to_string(number);
      std::vector<int>& set = sets_[name];
      line = {};
      for (std::int64_t k = 0; k < count; ++k) {
        const std::int64_t kind = next_integer(line, "member of the group");
        const std::int64_t label = next_integer(line, "member of the group");
        for (int other = 2; other < numbers; ++other) next_integer(line, "member of the group");
        if (kind == 7) {
          set.push_back(nodes_.at(label, file_, "group", number));
        } else if (kind == 8) {
          const auto found = element_by_label_.find(label);
          if (found == element_by_label_.end())
            file_.fail(fmt::format("element {} of group {} is not there", label, number));
          Element& element = elements_[found->second];
          if (element.group.empty()) element.group = name;
          const auto nodes = nodes_of(element);
          set.insert(set.end(), nodes.begin(), nodes.end());
        }
      }
    }
  }

  /// "Factors for converting to SI: divide by": the file's numbers stay as they are.
  void read_units() {
    std::string_view line;
    if (!next_record(line)) return;
    file_.integer(line, "code of the units");
    if (!next_record(line)) return;
    if (const double length = file_.real(line, "factor of length"); length != 1 && length > 0)
      warnings_.push_back(
          {file_.mark(), fmt::format("lengths of this file are in units of {:.6g} m; its numbers are "
                                     "taken as in the units that are asked for",
                                     1 / length)});
    while (next_record(line)) {
    }
  }

  std::span<const int> nodes_of(const Element& element) const {
    return {element_nodes_.data() + element.first, static_cast<std::size_t>(element.type->nodes)};
  }

  ImportedMesh finish() {
    ImportedMesh result;
    int dimension = 0;
    for (const Element& element : elements_) dimension = std::max(dimension, element.type->dimension);
    if (nodes_.size() == 0) file_.fail("has no nodes (data set 2411)");
    if (dimension < 2) file_.fail("has neither solid nor shell elements (data set 2412)");
    std::map<std::pair<int, std::string>, ElementGroup> groups;
    for (const Element& element : elements_) {
      if (element.type->dimension != dimension) continue;
      const std::string name = element.group.empty() ? std::to_string(element.property) : element.group;
      ElementGroup& group = groups[{element.type->code, name}];
      group.type = *element.type->ours;
      group.name = name;
      const auto nodes = nodes_of(element);
      for (const int place : order_of_nodes(group.type))
        group.nodes.push_back(nodes[static_cast<std::size_t>(place)]);
      group.labels.push_back(element.label);
    }
    for (auto& [key, group] : groups) result.mesh.groups.push_back(std::move(group));
    sets_.move_into(result.mesh);
    nodes_.move_into(result.mesh);
    result.warnings = std::move(warnings_);
    return result;
  }
};

ImportedMesh parse_unv(std::unique_ptr<TextFile> file, const std::string&) { return UnvReader(*file).read(); }

}  // namespace

const MeshFormat unv_format{.ending = ".unv",
                            .program = "I-DEAS, Salome, Gmsh",
                            .help = "universal file: nodes, elements, groups; needs --material",
                            .parse = parse_unv};

}  // namespace mimbre::fe
