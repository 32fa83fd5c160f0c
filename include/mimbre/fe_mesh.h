#pragma once
#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mimbre/fe.h"

/// Finite-element models of any origin: what importers give, assembly makes and reduction takes.
namespace mimbre::fe {

/// Numbering of nodes within an element as in Abaqus and CalculiX; pyramids: the base, the apex, amid the
/// sides of the base, amid the edges to the apex. From tri3 on they are shells.
enum class ElementType {
  tet4,
  tet10,
  hex8,
  hex20,
  wedge6,
  wedge15,
  pyramid5,
  pyramid13,
  tri3,
  quad4,
  tri6,
  quad8
};

constexpr int node_count(ElementType type) {
  constexpr int counts[] = {4, 10, 8, 20, 6, 15, 5, 13, 3, 4, 6, 8};
  return counts[static_cast<int>(type)];
}
constexpr bool is_shell(ElementType type) { return type >= ElementType::tri3; }

/// Directions in which a material is described.
struct Orientation {
  enum class Kind {
    rectangular,  ///< the same everywhere
    cylindrical   ///< 1 radial, 2 tangential, 3 along the axis of a cylinder
  };
  Kind kind = Kind::rectangular;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns: the directions; cylindrical: the last is
                                                       ///< the cylinder's axis, the others have no meaning
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();    ///< m, on the cylinder's axis
};

/// Elements of one type and one material.
struct ElementGroup {
  ElementType type = ElementType::tet4;
  std::string name;                  ///< element set or physical group that they come from
  int material = -1;                 ///< of SolidMesh::materials; -1: not specified
  double thickness = 0;              ///< m, shells
  std::vector<int> nodes;            ///< indices into SolidMesh::nodes, node_count(type) per element
  std::vector<std::int64_t> labels;  ///< of the elements in their file, for messages
  /// Of hex20 and quad8: 2 points each way, as C3D20R and S8R have them; motions without energy that the
  /// points do not see have a small stiffness.
  bool reduced_integration = false;
  double offset = 0;  ///< m, shells: of the middle surface from the nodes, along the normal
  /// Shells with an offset: its direction at each node of each element; empty: the element's normal.
  std::vector<Eigen::Vector3d> normals = {};
  /// Of each element, into SolidMesh::orientations; empty: the body's axes. Shells: direction 1 is projected
  /// onto the shell, 3 is the normal.
  std::vector<int> orientations = {};

  int size() const { return static_cast<int>(nodes.size()) / node_count(type); }
};

/// Stress = matrix · strain, order xx yy zz xy yz zx, shear strains twice the tensor's entries.
using ElasticMatrix = Eigen::Matrix<double, 6, 6>;

struct NamedMaterial {
  std::string name;
  Material material;
  /// In the directions of the elements' orientation, Pa, in place of Young's modulus and Poisson's ratio.
  std::optional<ElasticMatrix> elastic = std::nullopt;
};

/// The constants of an orthotropic material: Young's moduli, Poisson's ratios (12: contraction along 2 under
/// tension along 1), shear moduli.
struct EngineeringConstants {
  double E1 = 0, E2 = 0, E3 = 0, nu12 = 0, nu13 = 0, nu23 = 0, G12 = 0, G13 = 0, G23 = 0;
};
/// Throws std::invalid_argument where the constants are those of no material.
ElasticMatrix elastic_matrix(const EngineeringConstants& constants);

struct NodeSet {
  std::string name;
  std::vector<int> nodes;  ///< indices, ascending, each once
};

/// A rigid part at a node, which moves with it.
struct PointMass {
  std::string name;
  int node = 0;
  double mass = 0;                                    ///< kg
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< kg m², about its centre of mass, body axes
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();   ///< m, from the node to the centre of mass
};

/// A factor times one displacement or rotation of a node.
struct LinearTerm {
  int node = 0;
  int direction = 0;  ///< 0–2: translation along, 3–5: rotation about x, y, z (body axes)
  double factor = 0;
};

/// Between nodes; its stretch is a sum of terms.
struct Spring {
  std::string name;
  double stiffness = 0;  ///< force by stretch
  std::vector<LinearTerm> stretch;
};

/// A sum of terms that is always zero. The first term's dof is eliminated where it can be.
struct Equation {
  std::string name;
  std::vector<LinearTerm> terms;
  /// Only specifies where the first term's node goes in a direction in which nothing holds it. In a rigid
  /// interface it goes with the interface instead.
  bool loose = false;
};

/// Nodes that move as one rigid body with a node (RBE2, *RIGID BODY, *KINEMATIC).
struct RigidElement {
  std::string name;
  int reference = 0;
  std::vector<int> nodes;
  /// Motions of the nodes that follow; rotations only of nodes that have them.
  std::array<bool, 6> follows{true, true, true, true, true, true};
};

/// A node that moves as other nodes do in the mean, least squares (RBE3, *DISTRIBUTING).
struct MeanElement {
  std::string name;
  int reference = 0;
  std::vector<int> nodes;
  std::vector<double> weights;  ///< of the nodes; empty: equal
  /// Motions of the reference that follow the mean.
  std::array<bool, 6> follows{true, true, true, true, true, true};
};

/// Nodes have rotations where a shell, a beam, a rotation that a term names, an inertia, or the place of a
/// reference gives them.
struct SolidMesh {
  Eigen::Matrix3Xd nodes;            ///< body axes, m
  std::vector<std::int64_t> labels;  ///< of the nodes in their file, for messages
  std::vector<ElementGroup> groups;
  std::vector<BeamElement> beams;  ///< their nodes, like those of shells, have rotations
  std::vector<NamedMaterial> materials;
  std::vector<NodeSet> node_sets;
  std::vector<Orientation> orientations;
  std::vector<PointMass> point_masses;
  std::vector<Spring> springs;
  std::vector<Equation> equations;
  std::vector<RigidElement> rigid_elements;
  std::vector<MeanElement> mean_elements;
};

struct Dof {
  int node = 0;
  int direction = 0;  ///< 0–2: translation along, 3–5: rotation about x, y, z (body axes)
};

/// Free (unconstrained) matrices, dofs × dofs.
struct FeMatrices {
  Eigen::SparseMatrix<double> mass, stiffness;  ///< symmetric: lower triangles with the diagonal
  std::vector<Dof> dofs;                        ///< of each row, nodes ascending
  /// They are those of the mesh's elements, by assemble(); else another program made them.
  bool of_mesh = false;
  /// Where equations have eliminated dofs: displacements of `all_dofs` = expansion · those of the rows.
  Eigen::SparseMatrix<double> expansion = {};
  std::vector<Dof> all_dofs = {};
};

/// Consistent mass and stiffness of all elements, point masses and springs; equations, rigid and mean
/// elements are left to the reduction. Nodes of shells and beams have six dofs, those of solids only three,
/// those of nothing none. The result does not depend on the number of threads, to the last
/// bit; 0: as many as the machine runs. Throws std::invalid_argument that names the element (by its label)
/// for nodes that do not exist, positions that are not finite, elements without volume or turned inside out,
/// missing or unsound materials and thicknesses; std::length_error above 2³¹ − 1 entries in a matrix.
FeMatrices assemble(const SolidMesh& mesh, int threads = 0);

/// The matrices with masses lumped at the nodes (MassMatrix::lumped): of solids each node's part of the
/// diagonal of the element's consistent mass, scaled to the element's mass (Hinton, Rock, Zienkiewicz 1976)
/// and tilted to its centre of mass. The mass and its centre are exact, inertia converges with order 2.
/// Throws std::invalid_argument for shells and for matrices of another program.
FeMatrices lump_masses(const SolidMesh& mesh, FeMatrices matrices);

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

/// Stress and strain at points by displacement fields (columns; rows by `dofs`; what is missing is held):
/// in each solid extrapolated from where they are most accurate, then the mean over the solids that have the
/// node. Of shells, on the side where the offset points: the membrane's mean over the element and the
/// plate's bending, without transverse shear. Zero where no element of the kind is. Throws
/// std::invalid_argument as assemble does, and for sizes that do not fit.
Recovery recover(const SolidMesh& mesh, const std::vector<SurfacePoint>& points, const std::vector<Dof>& dofs,
                 const Eigen::Ref<const Eigen::MatrixXd>& displacements);

}  // namespace mimbre::fe
