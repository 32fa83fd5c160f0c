#pragma once
#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "mimbre/fe_mesh.h"
#include "mimbre/reduced_body.h"

/// Reduction of finite-element models of any origin to bodies.
namespace mimbre::fe {

/// Where a joint or a force takes hold: a set of nodes tied to a reference point.
struct Interface {
  enum class Tie {
    rigid,  ///< the nodes move as one rigid body with the point (RBE2)
    mean    ///< the point moves as the nodes do in the mean, equal weights (RBE3): nothing is stiffened
  };
  /// Which modes a motion of the point has. All but the first: of the bases craig_bampton, attachment and
  /// modal_truncation only, and not of the interface that a tangent frame moves with.
  enum class Motion {
    retained,  ///< a static mode
    free,      ///< none: a joint leaves it free, so no force acts that way, and dynamic modes have it
    held       ///< never moves: for what the mechanism holds in any case
  };
  std::string name;
  std::vector<int> nodes;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< body axes; see centre_of
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Tie tie = Tie::rigid;
  std::array<Motion, 6> motions{};  ///< displacements along the axes, turns about them
};

/// Mean of the nodes' positions.
Eigen::Vector3d centre_of(const SolidMesh& mesh, const std::vector<int>& nodes);

/// A force spread in equal parts over nodes; body axes.
struct SpreadLoad {
  std::string name;
  std::vector<int> nodes;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
};

/// Mode shapes from elsewhere, such as measured ones: displacements at some dofs, or at all of them.
struct UserModes {
  std::vector<Dof> dofs;   ///< of each row, each once
  Eigen::MatrixXd shapes;  ///< dofs × modes, body axes; any unit: only the shapes count
};

/// Stress by displacements as another program has it.
struct StressMatrix {
  /// 6·nodes × dofs, Pa by m and rad, columns as FeMatrices::dofs; rows xx yy zz xy yz zx of each node in
  /// turn, body axes.
  Eigen::SparseMatrix<double> matrix;
  std::vector<int> nodes;  ///< of the rows, indices into SolidMesh::nodes, each once
};

struct ModelReduction {
  enum class Frame {
    tangent,         ///< the body frame moves with the first interface
    centre_of_mass,  ///< it turns with the first interface and follows the centre of mass
    mean_axis        ///< in the mean motion: modes without momentum (Buckens)
  };
  enum class Basis {
    craig_bampton,   ///< static modes and the lowest modes with all interfaces held
    free_interface,  ///< the lowest modes of the free body and residual modes of forces (MacNeal; Rubin)
    krylov,          ///< static modes and moments of the response to forces at the interfaces
    /// The lowest modes of the body as its frame holds it, at the first interface (mean axes: of the free
    /// body), and attachment modes: static deflections by forces at the other interfaces (Hurty; Craig).
    attachment,
    /// These, and the static deflections by the inertia of accelerations of the body: modal truncation
    /// augmentation (Dickens, Nakagawa, Wittbrodt 1997) for forces at the interfaces, inertia and `loads`.
    modal_truncation
  };
  std::vector<Interface> interfaces;  ///< at least one
  Basis basis = Basis::craig_bampton;
  int dynamic_modes = 10;       ///< lowest modes, or Krylov vectors beyond the static modes
  double max_frequency = 0;     ///< Hz; not 0: all modes up to it in place of `dynamic_modes`; not of Krylov
  double krylov_frequency = 0;  ///< Hz: the moments are those about it
  /// %; not 0: of the modes with interfaces held only those that reach this share of the body's mass, see
  /// ReductionResult::effective_mass. Craig–Bampton only.
  double effective_mass = 0;
  /// Of each, what it deflects beyond the other modes with the interfaces held becomes a mode (of the free
  /// body by inertia relief where the basis is that of the free body); one that depends on them is left out.
  std::vector<SpreadLoad> loads;
  /// Beside the dynamic modes, or, with none of these, in their place.
  UserModes user_modes;
  Frame frame = Frame::tangent;
  /// Lumped: the matrices must be those of the mesh's elements, solids or beams; see lump_masses.
  MassMatrix mass_matrix = MassMatrix::consistent;
  double stiffness_damping = 0;  ///< s
  /// Matrices by which forces of inertia, gravity and at the interfaces stiffen the body
  /// (GeometricStiffness): solids, tangent frame, bases with static modes.
  bool geometric_stiffness = false;
  /// With nodes: these are the body's points, in this order, their stress is this one's, and strain is not
  /// known.
  StressMatrix stress;
  int free_modes = 10;  ///< of the full model, for the validation report: 0 saves a factorisation
  /// Called with what is being done and how much of it is, 0 to 1.
  std::function<void(const std::string& stage, double done)> progress;
};

struct ReductionResult {
  ReducedBody body;                   ///< with its checks
  Eigen::VectorXd fixed_frequencies;  ///< Hz, of the dynamic modes, interfaces held; Craig–Bampton only
  /// Of these modes, %: rows: share of the mass that moves with each in translations along the first
  /// interface's axes, of the moments of inertia in rotations about them.
  Eigen::MatrixXd effective_mass;
  Eigen::VectorXd free_frequencies;          ///< Hz, elastic modes of the full model, free
  Eigen::VectorXd reduced_free_frequencies;  ///< Hz, the same of the reduced body
};

/// Reduction of free matrices to a basis, Craig–Bampton's (Craig, Bampton 1968; Lugrís 2008, 2.7–2.9) or
/// another (Rubin 1975; Craig, Hale 1988; Dickens et al. 1997), shape integrals, modes made orthogonal. All
/// bases have the exact static compliance between the interfaces. Throws std::invalid_argument for:
/// interfaces without hold, nodes in two of them, matrices that are not those of a free elastic body, options
/// that do not go together.
ReductionResult reduce(const SolidMesh& mesh, const FeMatrices& matrices, const ModelReduction& options);

/// What matrices must be, whatever body they come from: sizes, finite, definite mass, six rigid motions
/// without force, plausible units. Each line reports its result.
std::vector<Check> check_matrices(const SolidMesh& mesh, const FeMatrices& matrices);

}  // namespace mimbre::fe
