#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace mimbre {

/// A frame on a flexible body to which joints, forces and outputs attach. Undeformed pose in body axes; moves
/// by `X y` and turns by the rotation vector `X_theta y`, both in body axes, y the modal amplitudes.
struct BodyFrame {
  std::string name;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< frame axes to body axes
  Eigen::Matrix3Xd X;                                      ///< 3 × modes
  Eigen::Matrix3Xd X_theta;                                ///< 3 × modes
};

/// The finite-element mesh behind the modes, for inertia by projection (Lugrís 2008, 2.76–2.90). Undeformed
/// positions are ReducedBody::nodes. Not needed for inertia by shape integrals.
struct MeshInertia {
  int dofs_per_node = 6;  ///< 6: translations, then rotations, of each node in turn; 3: translations
  Eigen::SparseMatrix<double> mass;  ///< M*, dofs × dofs, symmetric, full storage, body axes
  Eigen::MatrixXd shapes;            ///< Φ, dofs × modes
  /// Nodes × nodes: consistent mass of the translations alone, interpolated as in isoparametric elements
  /// (Lugrís 2008, 2.4.1). Empty: what M* has for the translations.
  Eigen::SparseMatrix<double> nodal_mass;
};

/// Large deflections: products of amplitudes that count as further amplitudes, so that displacements (and the
/// strain energy) are quadratic (of degree four) in the modes' amplitudes while all integrals stay constant.
/// "Extended" blocks have `modes` columns for the amplitudes y, then one for each product y_a y_b.
struct SecondOrder {
  std::vector<std::array<int, 2>> products;  ///< (a, b), a ≤ b
  Eigen::Matrix3Xd S;                        ///< ∫ X dm, extended
  std::array<Eigen::Matrix3Xd, 3> S_position;
  std::array<std::array<Eigen::MatrixXd, 3>, 3> S_modes;
  Eigen::MatrixXd mass_matrix;
  /// Elastic force on the extended amplitudes η: stiffnessᵀ η. Symmetric where it derives from an energy
  /// ½ ηᵀ K η; published nonlinear-stiffness forces do not.
  Eigen::MatrixXd stiffness;
  std::vector<Eigen::Matrix3Xd> frame_shapes;  ///< X of each of the body's frames, extended
  Eigen::MatrixXd node_shapes;                 ///< 3·nodes × extended
  Eigen::MatrixXd mesh_shapes;                 ///< of MeshInertia, dofs × extended; empty without a mesh
};

/// All that dynamics knows of a flexible body, wherever it comes from. SI units, body axes throughout.
/// Modes are mass- and stiffness-orthogonal when `make_orthogonal` was applied (built-in bodies always are).
struct ReducedBody {
  std::string name;
  int modes = 0;
  std::vector<std::string> mode_names;  ///< the user's view: "static ball.n", "dynamic 1", …

  /// Inertia shape integrals (Lugrís 2008, 3.6–3.11).
  double mass = 0;
  Eigen::Vector3d first_moment = Eigen::Vector3d::Zero();   ///< m̄u = ∫ r̄u dm
  Eigen::Matrix3d second_moment = Eigen::Matrix3d::Zero();  ///< P̄u = ∫ r̄u r̄uᵀ dm
  Eigen::Matrix3Xd S;                                       ///< ∫ X dm, 3 × modes
  std::array<Eigen::Matrix3Xd, 3> S_position;               ///< S̄^i = ∫ r̄u,i X dm, 3 × modes each
  std::array<std::array<Eigen::MatrixXd, 3>, 3> S_modes;    ///< S^ij = ∫ Xiᵀ Xj dm, modes × modes each
  Eigen::MatrixXd mass_matrix;  ///< Mff (with rotary terms of the mesh), modes × modes
  Eigen::MatrixXd stiffness;    ///< modes × modes
  Eigen::MatrixXd damping;      ///< modes × modes

  std::vector<BodyFrame> frames;

  /// user amplitudes = user_from_modal * y; identity until make_orthogonal is applied.
  Eigen::MatrixXd user_from_modal;
  Eigen::VectorXd eigenfrequencies;  ///< of the reduced matrices, rad/s, ascending, when orthogonal

  /// For drawing and output: mesh nodes (3 × nodes), mode shapes (3·nodes × modes), lines between nodes.
  Eigen::Matrix3Xd nodes;
  Eigen::MatrixXd node_shapes;
  std::vector<std::array<int, 2>> lines;
  double line_radius = 0.01;  ///< m, for drawing

  std::optional<SecondOrder> second_order;  ///< absent: linear in the amplitudes
  std::optional<MeshInertia> mesh_inertia;  ///< absent: inertia by shape integrals only

  /// Index of a frame by name, -1 when there is none.
  int find_frame(const std::string& frame_name) const;
};

/// Makes Mff = I and K = diag(ω²) by the eigenproblem of the reduced matrices; every mode block rotates
/// along. Same space, so nothing physical changes. Throws std::invalid_argument when Mff is not positive
/// definite.
void make_orthogonal(ReducedBody& body);

/// Checks sizes, finite numbers, symmetry, positive definiteness of mass and triangle inequality of the
/// inertia. Returns one message per violation; empty when sound.
std::vector<std::string> check(const ReducedBody& body);

/// One HDF5 file (layout in docs/reduced-body-format.md). Throw InputError naming the file and what is wrong.
void save(const ReducedBody& body, const std::string& path);
ReducedBody load_reduced_body(const std::string& path);

}  // namespace mimbre
