#include "fe_files/gmsh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "fe_files/mesh_builder.h"
#include "fe_files/mesh_formats.h"
#include "fe_files/text.h"

// Format: Gmsh reference manual, "MSH file format" (4.1) and "Legacy formats" (2.2); numbering of the nodes:
// "Node ordering" there.

namespace mimbre::fe {
namespace {

/// One of Gmsh's element types. Those without `ours` can only be parts of boundaries.
struct GmshType {
  int code, dimension, nodes;
  const char* name;
  std::optional<ElementType> ours = {};
};

constexpr GmshType kGmshTypes[] = {
    {1, 1, 2, "line"},
    {2, 2, 3, "triangle", ElementType::tri3},
    {3, 2, 4, "quadrangle", ElementType::quad4},
    {4, 3, 4, "tetrahedron", ElementType::tet4},
    {5, 3, 8, "hexahedron", ElementType::hex8},
    {6, 3, 6, "prism", ElementType::wedge6},
    {7, 3, 5, "pyramid", ElementType::pyramid5},
    {8, 1, 3, "3-node line"},
    {9, 2, 6, "6-node triangle", ElementType::tri6},
    {10, 2, 9, "9-node quadrangle"},
    {11, 3, 10, "10-node tetrahedron", ElementType::tet10},
    {12, 3, 27, "27-node hexahedron"},
    {13, 3, 18, "18-node prism"},
    {14, 3, 14, "14-node pyramid"},
    {15, 0, 1, "point"},
    {16, 2, 8, "8-node quadrangle", ElementType::quad8},
    {17, 3, 20, "20-node hexahedron", ElementType::hex20},
    {18, 3, 15, "15-node prism", ElementType::wedge15},
    {19, 3, 13, "13-node pyramid", ElementType::pyramid13},
    {20, 2, 9, "9-node triangle"},
    {21, 2, 10, "10-node triangle"},
    {26, 1, 4, "4-node line"},
    {27, 1, 5, "5-node line"},
    {29, 3, 20, "20-node tetrahedron"},
};

const GmshType& type_of(std::int64_t code, const TextFile& file) {
  for (const GmshType& type : kGmshTypes)
    if (type.code == code) return type;
  file.fail(fmt::format("element type {} is not known", code));
}

/// Where each of our nodes (Abaqus numbering) stands in Gmsh's element.
std::vector<int> node_order(ElementType type) {
  switch (type) {
    case ElementType::tet10:
      return {0, 1, 2, 3, 4, 5, 6, 7, 9, 8};
    case ElementType::hex20:
      return {0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15};
    case ElementType::wedge15:
      return {0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11};
    case ElementType::pyramid13:
      return {0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12};
    default: {
      std::vector<int> same(static_cast<std::size_t>(node_count(type)));
      for (std::size_t i = 0; i < same.size(); ++i) same[i] = static_cast<int>(i);
      return same;
    }
  }
}

/// Elements of one type and physical group, in Gmsh's numbering.
struct Block {
  std::vector<int> nodes;
  std::vector<std::int64_t> labels;
};

using Physical = std::pair<int, std::int64_t>;  // dimension, tag

class GmshReader {
 public:
  explicit GmshReader(TextFile& file) : file_(file) {}

  ImportedMesh read() {
    read_format();
    std::string_view line;
    bool nodes = false, elements = false;
    while (file_.next(line)) {
      std::string_view rest = line;
      const std::string section(next_word(rest));
      if (section.empty()) continue;
      if (!section.starts_with('$'))
        file_.fail(fmt::format("'{}' stands outside of all sections ($Nodes ... $EndNodes)", shown(line)));
      if (section == "$PhysicalNames") {
        read_names();
      } else if (section == "$Entities" && version_4_) {
        read_entities();
      } else if (section == "$PartitionedEntities") {
        file_.fail("is partitioned; save the mesh without partitions");
      } else if (section == "$Nodes") {
        version_4_ ? read_nodes_4() : read_nodes_2();
        nodes = true;
      } else if (section == "$Elements") {
        if (!nodes) file_.fail("$Nodes must stand before $Elements");
        version_4_ ? read_elements_4() : read_elements_2();
        elements = true;
      } else {
        skip_to_end(section);
        continue;
      }
      expect_end(section);
    }
    if (!nodes || !elements) file_.fail("ends without $Nodes and $Elements");
    return finish();
  }

 private:
  TextFile& file_;
  bool version_4_ = false;
  NodeTable nodes_;
  std::map<Physical, std::string> names_;
  std::map<Physical, std::vector<std::int64_t>> physicals_of_entity_;  // version 4
  std::map<std::pair<int, std::int64_t>, Block> blocks_;               // by type's code and physical tag
  std::map<Physical, std::vector<int>> boundary_;

  std::int64_t count(std::string_view& rest, const char* what) {
    const std::int64_t value = file_.integer(rest, what);
    if (value < 0) file_.fail(fmt::format("{} {} is negative", what, value));
    return value;
  }

  std::int64_t magnitude(std::int64_t tag) const {
    if (tag == std::numeric_limits<std::int64_t>::min())
      file_.fail(fmt::format("{} is no physical group", tag));
    return tag < 0 ? -tag : tag;
  }

  void expect_end(const std::string& section) {
    const std::string_view line = file_.expect(section.c_str());
    if (trimmed(line) != "$End" + section.substr(1))
      file_.fail(fmt::format("'{}' stands where $End{} should", shown(line), section.substr(1)));
  }
  void skip_to_end(const std::string& section) {
    const std::string end = "$End" + section.substr(1);
    while (trimmed(file_.expect(shown(section).c_str())) != end) {
    }
  }

  void read_format() {
    std::string_view line = file_.expect("the file's head");
    if (trimmed(line) != "$MeshFormat") file_.fail("is no Gmsh mesh: the first line must be $MeshFormat");
    line = file_.expect("$MeshFormat");
    const double version = file_.real(line, "version of the format");
    const std::int64_t binary = file_.integer(line, "kind of file");
    if (binary != 0) file_.fail("is binary; save it as text: gmsh -format msh41 (or Mesh.Binary = 0)");
    version_4_ = version >= 4;
    if (version < 2 || (version >= 3 && version != 4.1))
      file_.fail(fmt::format("has format {}; 2.2 and 4.1 are read: gmsh -format msh41", version));
    expect_end("$MeshFormat");
  }

  void read_names() {
    std::string_view line = file_.expect("$PhysicalNames");
    for (std::int64_t n = count(line, "count of names"); n > 0; --n) {
      line = file_.expect("$PhysicalNames");
      const auto dimension = static_cast<int>(file_.integer(line, "dimension"));
      const std::int64_t tag = file_.integer(line, "tag");
      line = trimmed(line);
      if (line.size() < 2 || line.front() != '"' || line.back() != '"')
        file_.fail(fmt::format("'{}' is no name in quotes", shown(line)));
      names_[{dimension, tag}] = std::string(line.substr(1, line.size() - 2));
    }
  }

  void read_entities() {
    std::string_view line = file_.expect("$Entities");
    std::array<std::int64_t, 4> counts{};
    for (std::int64_t& n : counts) n = count(line, "count of entities");
    for (int dimension = 0; dimension < 4; ++dimension)
      for (std::int64_t n = counts[static_cast<std::size_t>(dimension)]; n > 0; --n) {
        line = file_.expect("$Entities");
        const std::int64_t tag = file_.integer(line, "tag");
        for (int i = 0; i < (dimension == 0 ? 3 : 6); ++i) file_.real(line, "bound of the entity");
        const std::int64_t physicals = count(line, "count of physical groups");
        std::vector<std::int64_t>& tags = physicals_of_entity_[{dimension, tag}];
        // The sign only gives the orientation.
        for (std::int64_t i = 0; i < physicals; ++i) {
          const std::int64_t physical = file_.integer(line, "physical group");
          tags.push_back(magnitude(physical));
        }
      }
  }

  void add_node(std::int64_t label, std::string_view& line) {
    Eigen::Vector3d position;
    for (double& x : position) x = file_.real(line, "coordinate");
    nodes_.add(label, position, file_);
  }

  void read_nodes_2() {
    std::string_view line = file_.expect("$Nodes");
    for (std::int64_t n = count(line, "count of nodes"); n > 0; --n) {
      line = file_.expect("$Nodes");
      const std::int64_t label = file_.integer(line, "node number");
      add_node(label, line);
    }
  }

  void read_nodes_4() {
    std::string_view line = file_.expect("$Nodes");
    const std::int64_t blocks = count(line, "count of node blocks");
    const std::int64_t all = count(line, "count of nodes");
    std::vector<std::int64_t> labels;
    for (std::int64_t block = 0; block < blocks; ++block) {
      line = file_.expect("$Nodes");
      for (int i = 0; i < 3; ++i) file_.integer(line, "entity of the nodes");
      const std::int64_t n = count(line, "count of nodes");
      labels.clear();
      for (std::int64_t i = 0; i < n; ++i) {
        line = file_.expect("$Nodes");
        labels.push_back(file_.integer(line, "node number"));
      }
      for (const std::int64_t label : labels) {
        line = file_.expect("$Nodes");
        add_node(label, line);
      }
    }
    if (nodes_.size() != all)
      file_.fail(fmt::format("$Nodes announces {} nodes and has {}", all, nodes_.size()));
  }

  /// The element of which the rest of the line has the nodes; `physicals`: the groups that it belongs to.
  void add_element(std::int64_t label, const GmshType& type, const std::vector<std::int64_t>& physicals,
                   std::string_view& line) {
    std::array<int, 27> nodes{};
    for (int i = 0; i < type.nodes; ++i)
      nodes[static_cast<std::size_t>(i)] =
          nodes_.at(file_.integer(line, "node of the element"), file_, "element", label);
    const auto last = nodes.begin() + type.nodes;
    for (const std::int64_t physical : physicals) {
      std::vector<int>& set = boundary_[{type.dimension, physical}];
      set.insert(set.end(), nodes.begin(), last);
    }
    if (type.dimension < 2) return;
    Block& block = blocks_[{type.code, physicals.empty() ? 0 : physicals.front()}];
    block.nodes.insert(block.nodes.end(), nodes.begin(), last);
    block.labels.push_back(label);
  }

  void read_elements_2() {
    std::string_view line = file_.expect("$Elements");
    std::vector<std::int64_t> physicals;
    for (std::int64_t n = count(line, "count of elements"); n > 0; --n) {
      line = file_.expect("$Elements");
      const std::int64_t label = file_.integer(line, "element number");
      const GmshType& type = type_of(file_.integer(line, "element type"), file_);
      const std::int64_t tags = count(line, "count of tags");
      physicals.clear();
      for (std::int64_t i = 0; i < tags; ++i) {
        const std::int64_t tag = file_.integer(line, "tag");
        if (i == 0 && tag != 0) physicals.push_back(magnitude(tag));
      }
      add_element(label, type, physicals, line);
    }
  }

  void read_elements_4() {
    static const std::vector<std::int64_t> none;
    std::string_view line = file_.expect("$Elements");
    const std::int64_t blocks = count(line, "count of element blocks");
    const std::int64_t all = count(line, "count of elements");
    std::int64_t seen = 0;
    for (std::int64_t block = 0; block < blocks; ++block) {
      line = file_.expect("$Elements");
      const auto dimension = static_cast<int>(file_.integer(line, "dimension"));
      const std::int64_t entity = file_.integer(line, "entity of the elements");
      const GmshType& type = type_of(file_.integer(line, "element type"), file_);
      const auto found = physicals_of_entity_.find({dimension, entity});
      const std::int64_t n = count(line, "count of elements");
      for (std::int64_t i = 0; i < n; ++i, ++seen) {
        line = file_.expect("$Elements");
        const std::int64_t label = file_.integer(line, "element number");
        add_element(label, type, found == physicals_of_entity_.end() ? none : found->second, line);
      }
    }
    if (seen != all) file_.fail(fmt::format("$Elements announces {} elements and has {}", all, seen));
  }

  std::string name_of(int dimension, std::int64_t tag) const {
    const auto found = names_.find({dimension, tag});
    return found != names_.end() ? found->second : tag == 0 ? std::string() : std::to_string(tag);
  }

  /// Format 2 repeats an element for each of its physical groups: it must not weigh twice.
  static void drop_repeated(std::vector<ElementGroup>& groups) {
    struct Key {
      std::array<int, 8> corners;
      int group, element;
    };
    std::vector<Key> keys;
    for (std::size_t g = 0; g < groups.size(); ++g)
      for (int e = 0; e < groups[g].size(); ++e) {
        Key key{{-1, -1, -1, -1, -1, -1, -1, -1}, static_cast<int>(g), e};
        const int n = node_count(groups[g].type);
        for (int i = 0; i < std::min(n, 8); ++i)
          key.corners[static_cast<std::size_t>(i)] = groups[g].nodes[static_cast<std::size_t>(e * n + i)];
        std::sort(key.corners.begin(), key.corners.end());
        keys.push_back(key);
      }
    const auto order = [](const Key& a, const Key& b) {
      return std::tie(a.corners, a.group, a.element) < std::tie(b.corners, b.group, b.element);
    };
    std::sort(keys.begin(), keys.end(), order);
    std::vector<std::vector<char>> repeated;
    for (const ElementGroup& group : groups) repeated.emplace_back(group.labels.size(), 0);
    for (std::size_t i = 1; i < keys.size(); ++i)
      if (keys[i].corners == keys[i - 1].corners)
        repeated[static_cast<std::size_t>(keys[i].group)][static_cast<std::size_t>(keys[i].element)] = 1;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      ElementGroup kept = groups[g];
      kept.nodes.clear();
      kept.labels.clear();
      const auto n = static_cast<std::ptrdiff_t>(node_count(kept.type));
      for (std::size_t e = 0; e < groups[g].labels.size(); ++e) {
        if (repeated[g][e]) continue;
        kept.labels.push_back(groups[g].labels[e]);
        const auto first = groups[g].nodes.begin() + static_cast<std::ptrdiff_t>(e) * n;
        kept.nodes.insert(kept.nodes.end(), first, first + n);
      }
      groups[g] = std::move(kept);
    }
    std::erase_if(groups, [](const ElementGroup& group) { return group.labels.empty(); });
  }

  ImportedMesh finish() {
    ImportedMesh result;
    const bool solid = std::any_of(blocks_.begin(), blocks_.end(), [&](const auto& item) {
      return type_of(item.first.first, file_).dimension == 3;
    });
    for (auto& [key, block] : blocks_) {
      const GmshType& type = type_of(key.first, file_);
      if (type.dimension != (solid ? 3 : 2)) continue;
      if (!type.ours)
        file_.fail(fmt::format(
            "element {} is a {}, of which no body can be made; there are tetrahedra (4 or 10 "
            "nodes), hexahedra (8, 20), prisms (6, 15) and pyramids (5, 13), and as shells triangles (3, 6) "
            "and quadrangles (4, 8). Second order without extra nodes: Mesh.SecondOrderIncomplete = 1",
            block.labels.front(), type.name));
      ElementGroup group;
      group.type = *type.ours;
      group.name = name_of(type.dimension, key.second);
      const std::vector<int> order = node_order(group.type);
      group.nodes.reserve(block.nodes.size());
      for (std::size_t first = 0; first < block.nodes.size(); first += order.size())
        for (const int place : order)
          group.nodes.push_back(block.nodes[first + static_cast<std::size_t>(place)]);
      group.labels = std::move(block.labels);
      block = {};
      result.mesh.groups.push_back(std::move(group));
    }
    if (result.mesh.groups.empty())
      file_.fail(
          "has neither volume nor surface elements (with physical groups Gmsh saves only their elements)");
    if (result.mesh.groups.size() > 1 && !version_4_) drop_repeated(result.mesh.groups);
    NodeSets sets;
    for (auto& [physical, nodes] : boundary_) {
      std::vector<int>& set = sets[name_of(physical.first, physical.second)];
      set.insert(set.end(), nodes.begin(), nodes.end());
    }
    sets.move_into(result.mesh);
    nodes_.move_into(result.mesh);
    return result;
  }
};

}  // namespace

ImportedMesh parse_gmsh(TextFile& file) { return GmshReader(file).read(); }

const MeshFormat gmsh_format{
    .ending = ".msh",
    .program = "Gmsh",
    .help = "Gmsh 2.2 or 4.1, ASCII: needs --material",
    .parse = [](std::unique_ptr<TextFile> file, const std::string&) { return parse_gmsh(*file); }};

}  // namespace mimbre::fe
