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

/// Consistent mass and stiffness of all elements. Nodes of shells and beams have six dofs, those of solids
/// only three, those of no element none. The result does not depend on the number of threads, to the last
/// bit; 0: as many as the machine runs. Throws std::invalid_argument that names the element (by its label)
/// for nodes that do not exist, positions that are not finite, elements without volume or turned inside out,
/// missing or unsound materials and thicknesses; std::length_error above 2³¹ − 1 entries in a matrix.
FeMatrices assemble(const SolidMesh& mesh, int threads = 0);

/// Geometric stiffness KG(σ), σ of the displacements (in the order of FeMatrices::dofs) by linear elasticity:
/// lower triangle, dofs × dofs, linear in the displacements; K + KG is the stiffness of the stressed mesh.
/// Solids only: throws std::invalid_argument for shells and beams, and as assemble does.
Eigen::SparseMatrix<double> geometric_stiffness(const SolidMesh& mesh,
                                                const Eigen::Ref<const Eigen::VectorXd>& displacements,
                                                int threads = 0);

/// A node as solids see it, or a place on one side of a shell.
struct SurfacePoint {
  int node = 0;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< from the node to the side of the shell, m; 0: solids
};

/// Rows xx yy zz xy yz zx of each point in turn, body axes, Pa; shear strains twice the tensor's entries.
/// 6·points × fields.
struct Recovery {
  Eigen::MatrixXd stress, strain;
};

/// Stress and strain at points by displacement fields (columns; rows as `dofs` say, what is missing is held):
/// in each solid extrapolated from where they are most accurate, then the mean over the solids that have the
/// node. Of shells, on the side where the offset points: the membrane's mean over the element and the
/// plate's bending, without transverse shear. Zero where no element of the kind is. Throws
/// std::invalid_argument as assemble does, and for sizes that do not fit.
Recovery recover(const SolidMesh& mesh, const std::vector<SurfacePoint>& points, const std::vector<Dof>& dofs,
                 const Eigen::Ref<const Eigen::MatrixXd>& displacements);

}  // namespace mimbre::fe
