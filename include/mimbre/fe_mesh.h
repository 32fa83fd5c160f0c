#pragma once
#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cstdint>
#include <string>
#include <vector>

#include "mimbre/fe.h"

/// Finite-element models of any origin: what importers give, assembly makes and reduction takes.
namespace mimbre::fe {

/// Numbering of nodes within an element as in Abaqus and CalculiX. The last two are shells.
enum class ElementType { tet4, tet10, hex8, hex20, wedge6, wedge15, tri3, quad4 };

constexpr int node_count(ElementType type) {
  constexpr int counts[] = {4, 10, 8, 20, 6, 15, 3, 4};
  return counts[static_cast<int>(type)];
}
constexpr bool is_shell(ElementType type) { return type >= ElementType::tri3; }

/// Elements of one type and one material.
struct ElementGroup {
  ElementType type = ElementType::tet4;
  std::string name;                  ///< element set or physical group that they come from
  int material = -1;                 ///< of SolidMesh::materials; -1: none said
  double thickness = 0;              ///< m, shells
  std::vector<int> nodes;            ///< indices into SolidMesh::nodes, node_count(type) per element
  std::vector<std::int64_t> labels;  ///< of the elements in their file, for messages

  int size() const { return static_cast<int>(nodes.size()) / node_count(type); }
};

struct NamedMaterial {
  std::string name;
  Material material;
};

struct NodeSet {
  std::string name;
  std::vector<int> nodes;  ///< indices, ascending, each once
};

struct SolidMesh {
  Eigen::Matrix3Xd nodes;            ///< body axes, m
  std::vector<std::int64_t> labels;  ///< of the nodes in their file, for messages
  std::vector<ElementGroup> groups;
  std::vector<BeamElement> beams;  ///< their nodes, like those of shells, have rotations
  std::vector<NamedMaterial> materials;
  std::vector<NodeSet> node_sets;
};

struct Dof {
  int node = 0;
  int direction = 0;  ///< 0–2: translation along, 3–5: rotation about x, y, z (body axes)
};

/// Free (unconstrained) matrices, dofs × dofs.
struct FeMatrices {
  Eigen::SparseMatrix<double> mass, stiffness;  ///< symmetric: lower triangles with the diagonal
  std::vector<Dof> dofs;                        ///< of each row, nodes ascending
};

}  // namespace mimbre::fe
