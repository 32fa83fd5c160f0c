#pragma once
#include <Eigen/Core>
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
  std::string name;
  std::vector<int> nodes;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< body axes; see centre_of
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Tie tie = Tie::rigid;
};

/// Mean of the nodes' positions.
Eigen::Vector3d centre_of(const SolidMesh& mesh, const std::vector<int>& nodes);

struct ModelReduction {
  enum class Frame {
    tangent,   ///< the body frame moves with the first interface
    mean_axis  ///< origin in the centre of mass, modes without momentum (Buckens)
  };
  std::vector<Interface> interfaces;  ///< at least one
  int dynamic_modes = 10;             ///< lowest modes with all interfaces held
  Frame frame = Frame::tangent;
  double stiffness_damping = 0;  ///< s
  int free_modes = 10;           ///< of the full model, for the certificate: 0 saves a factorisation
  /// Called with what is being done and how much of it is, 0 to 1.
  std::function<void(const std::string& stage, double done)> progress;
};

struct ReductionResult {
  ReducedBody body;                          ///< with its checks
  Eigen::VectorXd fixed_frequencies;         ///< Hz, of the dynamic modes, interfaces held
  Eigen::VectorXd free_frequencies;          ///< Hz, elastic modes of the full model, free
  Eigen::VectorXd reduced_free_frequencies;  ///< Hz, the same of the reduced body
};

/// Craig–Bampton reduction (Craig, Bampton 1968; Lugrís 2008, 2.7–2.9) of free matrices: static modes of the
/// interfaces' motions, dynamic modes with the interfaces held, shape integrals, modes made orthogonal.
/// Throws std::invalid_argument that says what is wrong: interfaces without hold, nodes in two of them,
/// matrices that are not those of a free elastic body.
ReductionResult reduce(const SolidMesh& mesh, const FeMatrices& matrices, const ModelReduction& options);

/// What matrices must be, whatever body they come from: sizes, finite, definite mass, six rigid motions
/// without force, plausible units. Each line says what it found.
std::vector<Check> check_matrices(const SolidMesh& mesh, const FeMatrices& matrices);

}  // namespace mimbre::fe
