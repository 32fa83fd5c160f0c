#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "fe/elements/shear_coefficient.h"
#include "fe_files/inp/inp_lines.h"
#include "fe_files/mesh_builder.h"
#include "mimbre/fe_import.h"

namespace mimbre::fe {

/// What an element type of an .inp file is to us.
struct InpType {
  enum class Kind {
    element,
    beam,
    boundary_only,
    mass,
    inertia,
    spring_along,
    spring_between
  } kind = Kind::element;
  ElementType type = ElementType::tet4;
  int nodes = 0;
  bool reduced = false;  ///< integration
};

struct InpElement {
  std::int64_t label = 0;
  std::size_t first = 0;  ///< into InpModel::element_nodes
  int type = 0;           ///< into InpModel::types
  int home = -1;          ///< into InpModel::element_sets: the ELSET of its *ELEMENT
  int section = -1;       ///< into InpModel::sections
};

/// End of the warning about a section, which refuses the model where there are no matrices beside the file.
inline constexpr const char* no_elasticity = "has no *ELASTIC that is read: a body is linear elastic";

/// A layer of a shell, from the bottom to the top.
struct InpPly {
  double thickness = 0;
  std::string material, orientation;
};

struct InpSection {
  enum class Kind { solid, shell, beam } kind = Kind::solid;
  std::string element_set, material, orientation;
  double thickness = 0;
  double offset = 0;                                      ///< of the middle surface from the nodes
  std::vector<InpPly> plies;                              ///< COMPOSITE, in place of material and orientation
  Eigen::Vector2d beam_offset = Eigen::Vector2d::Zero();  ///< of a beam's axis from the nodes, along 1 and 2
  Section beam;
  ShearCoefficient shear;                                ///< of a beam's section
  Eigen::Vector3d first_axis = Eigen::Vector3d::Zero();  ///< of a beam's section
  Mark mark;
};

/// *MASS, *ROTARY INERTIA, *SPRING: numbers for the elements of a set.
struct InpPointProperty {
  enum class Kind { mass, inertia, spring } kind = Kind::mass;
  std::string element_set;
  std::array<double, 6> values{};   ///< mass, inertia, stiffness
  std::array<int, 2> directions{};  ///< of springs between dofs
  Mark mark;
};

struct InpOrientation {
  std::string name;
  Orientation orientation;
};

/// Nodes of each face, corners first.
struct InpSurface {
  std::vector<std::vector<int>> faces;
};

struct InpTie {
  std::string slave, master;  ///< surfaces
  double tolerance = -1;      ///< −1: none given
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
  std::vector<InpPointProperty> point_properties;
  std::vector<InpOrientation> orientations;
  std::map<std::string, InpSurface> surfaces;  ///< small letters
  std::vector<InpTie> ties;
  std::vector<Equation> equations;
  std::set<int> turned_nodes;  ///< whose directions *TRANSFORM turns
  std::vector<RigidElement> rigid_elements;
  std::vector<MeanElement> mean_elements;
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

/// *MATERIAL, *ELASTIC, *DENSITY, *ORIENTATION; true when the keyword was one of them.
bool read_inp_material(InpModel& model, const InpKeyword& keyword);
/// *SOLID SECTION, *SHELL SECTION, *BEAM SECTION; true when the keyword was one of them.
bool read_inp_section(InpModel& model, const InpKeyword& keyword);
/// *MASS, *ROTARY INERTIA, *SPRING; true when the keyword was one of them.
bool read_inp_point_property(InpModel& model, const InpKeyword& keyword);
/// Masses and springs of the finished mesh.
void finish_inp_points(const InpModel& model, SolidMesh& mesh);
/// *EQUATION, *TRANSFORM, *MPC, *RIGID BODY, *COUPLING, *KINEMATIC COUPLING, *DISTRIBUTING COUPLING, *TIE;
/// true when the keyword was one of them.
bool read_inp_constraint(InpModel& model, const InpKeyword& keyword);
/// Refuses equations and springs between dofs of nodes whose directions *TRANSFORM turns.
void check_inp_transforms(const InpModel& model, const SolidMesh& mesh);
/// Equations of the ties, from the nodes of the finished mesh.
void finish_inp_ties(InpModel& model, SolidMesh& mesh);
/// The value of a parameter; throws where there is none.
const std::string& needed(const InpKeyword& keyword, const char* parameter);
/// `count` numbers, that may go on in further lines; throws where there are fewer.
std::vector<double> inp_numbers(InpModel& model, const InpKeyword& keyword, int count, const char* what);
/// Nodes that a field names: a label or a set. Empty where there are none.
std::vector<int> inp_nodes(const InpModel& model, std::string_view field);

/// Directions of the offsets of shells: means over the elements that meet nearly in line at a node.
void finish_inp_normals(SolidMesh& mesh);

/// *SURFACE, as a node set.
void read_inp_surface(InpModel& model, const InpKeyword& keyword);
/// Groups, beams and sets of the finished model.
ImportedMesh finish_inp(InpModel& model);

/// As read_inp of the public header, in the file's units. Without `includes`, *INCLUDE is refused.
ImportedMesh parse_inp(std::unique_ptr<TextFile> file, const std::string& folder, bool includes);

}  // namespace mimbre::fe
