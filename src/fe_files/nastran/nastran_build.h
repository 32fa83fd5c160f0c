#pragma once
#include <functional>
#include <map>
#include <string>
#include <unordered_map>
#include <vector>

#include "fe_files/nastran/nastran_model.h"

namespace mimbre::fe {

/// A deck on its way to a mesh.
struct NastranBuild {
  explicit NastranBuild(NastranModel& deck);

  NastranModel& model;
  SolidMesh mesh;
  std::unordered_map<std::int64_t, int> by_label;
  std::vector<std::int64_t> displacement_systems;  ///< of the nodes
  std::vector<char> rotates;                   ///< nodes whose rotations have a stiffness or follow others
  bool has_mass = false;                       ///< something in the deck has: what has none is meant so
  std::map<std::pair<int, int>, int> middles;  ///< by the ends of their sides
  std::map<std::string, int> materials;        ///< of the mesh, by their names

  /// Index of a node, −1 (and an error) when there is none.
  int node(std::int64_t label, const NastranPlace& place, const std::string& user);
  /// A node amid a side of a solid that the deck leaves out, which follows the mean of the side's ends.
  int amid(int a, int b);
  Eigen::Vector3d at(int node) const { return mesh.nodes.col(node); }
  /// Columns: the directions of a node's displacements.
  Eigen::Matrix3d directions(int node, const NastranPlace& place) const;
  /// A component of a node, times a factor, as terms in body axes.
  void add_component(int node, int component, double factor, const NastranPlace& place,
                     std::vector<LinearTerm>& terms) const;
  /// Along `axis`: displacement of a point at `arm` from the node.
  static void add_translation(int node, const Eigen::Vector3d& axis, const Eigen::Vector3d& arm,
                              double factor, std::vector<LinearTerm>& terms);
  static void add_rotation(int node, const Eigen::Vector3d& axis, double factor,
                           std::vector<LinearTerm>& terms);
  /// Sums terms of the same dof, drops what is zero and what rotates nodes without rotations.
  void tidy(std::vector<LinearTerm>& terms, bool keep_rotations) const;
  const NastranMaterial& material(std::int64_t label, const NastranPlace& user) const;
  /// Index in the mesh, made when it is new; `factor`: of stiffness; density in place of the material's.
  int mesh_material(const std::string& name, const Material& values,
                    const std::optional<ElasticMatrix>& elastic);
  /// With the line where it stands, for messages of the reduction.
  std::string named(const std::string& what, const NastranPlace& place) const;
  /// Runs `make`; what it throws is an error of the thing at `place`.
  void guarded(const std::string& what, const NastranPlace& place, const std::function<void()>& make);
};

void add_nastran_solids(NastranBuild& build);
void add_nastran_shells(NastranBuild& build);
void add_nastran_bars(NastranBuild& build);
void add_nastran_panels(NastranBuild& build);
void add_nastran_ties(NastranBuild& build);
/// Last: nodes that springs hold in some directions only go with the body in the others; masses on nodes
/// that nothing holds are left out.
void settle_nastran_loose_nodes(NastranBuild& build);

}  // namespace mimbre::fe
