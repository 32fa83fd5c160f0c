#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "fe_files/inp_lines.h"
#include "fe_files/mesh_builder.h"
#include "mimbre/fe_import.h"

namespace mimbre::fe {

/// What an element type of an .inp file is to us.
struct InpType {
  enum class Kind { element, beam, boundary_only } kind = Kind::element;
  ElementType type = ElementType::tet4;
  int nodes = 0;
};

struct InpElement {
  std::int64_t label = 0;
  std::size_t first = 0;  ///< into InpModel::element_nodes
  int type = 0;           ///< into InpModel::types
  int home = -1;          ///< into InpModel::element_sets: the ELSET of its *ELEMENT
  int section = -1;       ///< into InpModel::sections
};

struct InpSection {
  enum class Kind { solid, shell, beam } kind = Kind::solid;
  std::string element_set, material;
  double thickness = 0;
  Section beam;
  Eigen::Vector3d first_axis = Eigen::Vector3d::Zero();  ///< of a beam's section
  Mark mark;
};

struct InpElementSet {
  std::string name;
  std::vector<int> elements;
};

/// All of an .inp file while it is read.
struct InpModel {
  explicit InpModel(InpLines& source) : lines(source) {}

  InpLines& lines;
  NodeTable nodes;
  NodeSets node_sets;
  std::vector<InpType> types;
  std::vector<InpElement> elements;
  std::vector<int> element_nodes;
  std::unordered_map<std::int64_t, int> element_by_label;
  std::vector<InpElementSet> element_sets;
  std::map<std::string, int> element_set_by_name;  ///< small letters
  std::vector<NamedMaterial> materials;
  std::vector<InpSection> sections;
  std::vector<Diagnostic> warnings;
  std::set<std::string> warned;

  /// Index of the element set, which is made when it is new.
  int element_set(const std::string& name);
  /// The set that a card names and that must be there.
  const InpElementSet& known_element_set(const std::string& name, const Mark& mark) const;
  /// Once per `key`.
  void warn(const std::string& key, Mark mark, std::string message);
};

/// Appends, and drops what is there twice when there is more than the `universe` can give: sets that hold
/// sets that hold sets must not grow without bounds.
void add_members(const std::vector<int>& more, std::size_t universe, std::vector<int>& members);

/// *MATERIAL, *ELASTIC, *DENSITY; true when the keyword was one of them.
bool read_inp_material(InpModel& model, const InpKeyword& keyword);
/// *SOLID SECTION, *SHELL SECTION, *BEAM SECTION; true when the keyword was one of them.
bool read_inp_section(InpModel& model, const InpKeyword& keyword);
/// *SURFACE, as a node set.
void read_inp_surface(InpModel& model, const InpKeyword& keyword);
/// Groups, beams and sets of the finished model.
ImportedMesh finish_inp(InpModel& model);

/// As read_inp of the public header, in the file's units. Without `includes`, *INCLUDE is refused.
ImportedMesh parse_inp(std::unique_ptr<TextFile> file, const std::string& folder, bool includes);

}  // namespace mimbre::fe
