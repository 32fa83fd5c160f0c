#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "fe_files/nastran/nastran_systems.h"
#include "mimbre/fe_import.h"

/// A Nastran deck as it is read: the contents of its cards, by their numbers, in the deck's units and
/// systems.
namespace mimbre::fe {

/// A file's line; files are few, places are many.
struct NastranPlace {
  int file = 0, line = 0;
};

struct NastranGrid {
  std::int64_t label = 0, position_system = 0, displacement_system = 0;
  Eigen::Vector3d coordinates = Eigen::Vector3d::Zero();  ///< in position_system
  NastranPlace place;
};

/// Nodes of elements stand in NastranModel::element_nodes; 0: a blank field.
struct NastranSolid {
  std::int64_t label = 0, property = 0;
  std::size_t first = 0;
  ElementType type = ElementType::tet4;
  NastranPlace place;
};

struct NastranShell {
  std::int64_t label = 0, property = 0;
  std::size_t first = 0;
  ElementType type = ElementType::quad4;
  double angle = 0;                    ///< °, of the material's direction 1 from the first side
  std::optional<std::int64_t> system;  ///< in place of the angle
  std::optional<double> offset;        ///< of the middle surface along the normal
  std::array<double, 4> thickness{};   ///< at the corners; 0: that of the property
  bool relative_thickness = false;     ///< as shares of that of the property
  NastranPlace place;
};

/// CBAR, CBEAM, CROD, CTUBE, CONROD.
struct NastranBar {
  std::int64_t label = 0, property = 0;
  std::array<std::int64_t, 2> nodes{};
  bool rod = false, beam = false;
  bool has_direction = false;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< in the plane of the element's x and y
  std::int64_t direction_node = 0;                      ///< in its place
  std::string axes;  ///< of direction and offsets: G displacement, O, E element, B
  std::array<unsigned, 2> released{};
  std::array<Eigen::Vector3d, 2> offsets{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  NastranPlace place;
};

struct NastranMaterial {
  enum class Kind { isotropic, sheet, solid } kind = Kind::isotropic;
  double young = 0, poisson = 0, shear = 0, density = 0;
  Eigen::Matrix<double, 6, 6> elastic = Eigen::Matrix<double, 6, 6>::Zero();  ///< MAT8, MAT9, MAT11
  Eigen::Matrix3d sheet = Eigen::Matrix3d::Zero();                            ///< MAT2, MAT8: in-plane
  Eigen::Matrix2d sheet_shear = Eigen::Matrix2d::Zero();                      ///< MAT2, MAT8: zx, yz
  Eigen::Matrix2d shear_alone = Eigen::Matrix2d::Zero();  ///< the same where MID3 names the material
  NastranPlace place;
};

struct NastranShellProperty {
  std::int64_t membrane = 0, bending = 0, shear = 0, coupling = 0;  ///< materials; 0: none
  double thickness = 0, bending_ratio = 1, shear_ratio = 5.0 / 6;
  double mass = 0;  ///< per area, beyond the materials'
  struct Ply {
    std::int64_t material = 0;
    double thickness = 0, angle = 0;
  };
  std::vector<Ply> plies;  ///< PCOMP, from the bottom
  double bottom = 0;       ///< of the plies, along the normal from the nodes
  NastranPlace place;
};

struct NastranSolidProperty {
  std::int64_t material = 0;
  std::optional<std::int64_t> system;  ///< of the material; -1: the element's
  NastranPlace place;
};

/// CSHEAR: a sheet that carries shear alone.
struct NastranPanel {
  std::int64_t label = 0, property = 0;
  std::array<std::int64_t, 4> nodes{};
  NastranPlace place;
};

struct NastranPanelProperty {
  std::int64_t material = 0;
  double thickness = 0, mass = 0;
  std::array<double, 2> rods{};  ///< F1, F2: the share of it that works as rods along its sides
  NastranPlace place;
};

/// A bar's section by its area, moments of area about the centroid (1: bending in the plane of x and y, 2: of
/// x and z), torsion constant, shear factors (0: no shear deformation).
struct NastranSection {
  double area = 0, I1 = 0, I2 = 0, I12 = 0, J = 0, mass = 0;
  double shear1 = 0, shear2 = 0;
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();  ///< y, z from the element's axis
  double reach_y = 0, reach_z = 0;
  bool round = false;
};

struct NastranStation {
  double along = 0;  ///< 0 at end A, 1 at end B
  NastranSection section;
};

struct NastranBarProperty {
  std::int64_t material = 0;
  NastranSection section;  ///< of a tapered beam the mean of its ends
  /// Of a tapered beam, ascending from 0 to 1; between them the section changes linearly. Else empty.
  std::vector<NastranStation> stations;
  NastranPlace place;
};

struct NastranTerm {
  std::int64_t node = 0;
  int component = 0;  ///< 0–5, in the node's displacement system
  double factor = 0;
};

/// CELAS1 to CELAS4: between one or two components.
struct NastranScalar {
  std::int64_t label = 0, property = 0;  ///< 0: the value stands on the card
  double value = 0;
  std::array<std::int64_t, 2> nodes{};
  std::array<int, 2> components{-1, -1};
  std::string card;
  NastranPlace place;
};

struct NastranBush {
  std::int64_t label = 0, property = 0;
  std::array<std::int64_t, 2> nodes{};
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  std::int64_t direction_node = 0;
  std::optional<std::int64_t> system;
  double place_along = 0.5;
  std::optional<std::int64_t> offset_system;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  NastranPlace place;
};

/// CONM1, CONM2 and what CMASS cards make of a node.
struct NastranMass {
  std::int64_t label = 0, node = 0, system = 0;
  double mass = 0;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  NastranPlace place;
};

/// RBE2, RBAR, RBE1: nodes whose components follow a node.
struct NastranRigid {
  std::int64_t label = 0, reference = 0;
  std::vector<std::pair<std::int64_t, unsigned>> followers;  ///< node and components
  std::string card;
  NastranPlace place;
};

struct NastranMean {
  std::int64_t label = 0, reference = 0;
  unsigned components = 0;
  struct Node {
    std::int64_t node = 0;
    unsigned components = 0;
    double weight = 0;
  };
  std::vector<Node> nodes;
  NastranPlace place;
};

struct NastranEquation {
  std::int64_t set = 0;
  std::vector<NastranTerm> terms;
  NastranPlace place;
};

/// First and last of labels.
using NastranRange = std::array<std::int64_t, 2>;

struct NastranModel {
  std::vector<std::string> files;
  NastranSystems systems;
  std::vector<NastranGrid> grids;
  std::optional<std::pair<std::int64_t, std::int64_t>> grid_defaults;  ///< GRDSET: CP, CD
  std::vector<NastranRange> scalar_points;
  std::vector<std::int64_t> element_nodes;
  std::vector<NastranSolid> solids;
  std::vector<NastranShell> shells;
  std::vector<NastranBar> bars;
  std::vector<NastranPanel> panels;
  std::vector<NastranScalar> springs, scalar_masses;
  std::vector<NastranBush> bushes;
  std::vector<NastranMass> masses;
  std::vector<NastranRigid> rigid;
  std::vector<NastranMean> means;
  std::vector<NastranEquation> equations;  ///< MPC; those without a set always count (RROD)
  std::map<std::int64_t, std::vector<std::int64_t>> equation_sums;  ///< MPCADD
  std::map<std::int64_t, NastranMaterial> materials;
  std::map<std::int64_t, NastranShellProperty> shell_properties;
  std::map<std::int64_t, NastranSolidProperty> solid_properties;
  std::map<std::int64_t, NastranBarProperty> bar_properties;
  std::map<std::int64_t, NastranPanelProperty> panel_properties;
  std::map<std::int64_t, double> spring_properties, mass_properties;
  std::map<std::int64_t, std::array<double, 6>> bush_properties;
  std::map<std::int64_t, std::string> other_properties, other_materials;  ///< by the card's name
  std::map<std::string, std::vector<NastranRange>> sets;                  ///< nodes by name, such as SPC:3
  std::vector<std::int64_t> equation_sets;  ///< those that the case control takes
  bool has_control = false;                 ///< executive and case control stand before the bulk data
  NastranBar bar_defaults, beam_defaults;   ///< BAROR, BEAMOR
  double mass_factor = 1;                   ///< PARAM,WTMASS
  std::vector<std::string> matrices;        ///< DMIG heads, capitals

  bool grids_only = false;  ///< nothing but nodes, systems and the names of matrices is read

  std::vector<Diagnostic> errors, warnings;
  std::size_t more_errors = 0;
  std::map<std::string, std::size_t> left_out;  ///< warnings by key, to count what they stand for

  NastranPlace place(const Mark& mark);
  Mark mark(const NastranPlace& place) const;
  /// One more thing that is wrong; beyond a thousand they are only counted.
  void error(const Mark& mark, std::string message);
  /// Once per `key`.
  void warn(const std::string& key, const Mark& mark, std::string message);
  bool is_scalar_point(std::int64_t label) const;
  bool has_elements() const { return !solids.empty() || !shells.empty() || !bars.empty() || !panels.empty(); }
};

/// Bulk data without what stands before BEGIN BULK; what is wrong goes to `model.errors`.
void read_nastran_bulk(NastranLines& lines, NastranModel& model);
/// Executive and case control, where there is a line BEGIN BULK; false: there is none, all is bulk data.
bool read_nastran_control(NastranLines& lines, NastranModel& model);
/// Calls done with all lines read: elements of the deck as a mesh, in the deck's units. Throws InputError
/// with all that is wrong.
ImportedMesh finish_nastran(NastranModel& model);

/// Card handlers by what they read; false: the card is none of theirs.
bool read_nastran_element(NastranModel& model, const NastranCard& card);
bool read_nastran_property(NastranModel& model, const NastranCard& card);
bool read_nastran_tie(NastranModel& model, const NastranCard& card);

/// PBARL and PBEAML. Throws std::invalid_argument for a shape that is not known or sizes that do not fit.
std::size_t nastran_shape_sizes(const std::string& shape);
NastranSection nastran_section(const std::string& shape, const std::vector<double>& sizes);
/// Where a thin-walled section's shear centre lies; none where that is not known here (HAT, BOX1).
std::optional<Eigen::Vector2d> nastran_shear_centre(const std::string& shape,
                                                    const std::vector<double>& sizes);

}  // namespace mimbre::fe
