#pragma once
#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <functional>
#include <optional>
#include <vector>

#include "fe/elements/turning_cell.h"
#include "mimbre/beam_reduction.h"
#include "mimbre/fe_reduce.h"
#include "mimbre/reduced_body.h"

namespace mimbre {

namespace fe {

/// Nodes that move with a point as one rigid body: to the second order, too.
struct RigidNodes {
  std::vector<int> nodes;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::MatrixXd turn;  ///< 3 × modes
};

/// A mesh with its modes, and how it responds where all places are held.
struct StretchedMesh {
  const SolidMesh& mesh;
  const Eigen::SparseMatrix<double>& stiffness;  ///< dofs square, lower triangle at least
  std::vector<int> first_dof;                    ///< of each node, −1: it has none
  Eigen::MatrixXd shapes;                        ///< dofs × modes
  Eigen::MatrixXd lowest;  ///< modes × count, of unit stiffness: what the states of stress are of
  std::vector<RigidNodes> rigid;
  Eigen::MatrixXd unit_motions;  ///< dofs × 6·places: of each, its nodes moved alone (body axes)
  std::function<Eigen::MatrixXd(const Eigen::MatrixXd& forces)> respond;  ///< displacements, places held
  /// turning_cell, or turning_beam where there are beams only
  std::function<TurningCell(const MeshCells& cells, const Mesh& beams, int number)> cell;
};

/// Of unit stiffness, the lowest first: modes × count, or as many as there are.
Eigen::MatrixXd lowest_amplitudes(const ReducedBody& body, Eigen::Index count);

/// The states of stress are those that the lowest modes cause by pairs: with all places held the mesh
/// responds by −K⁻¹ f to the forces f with which its elements resist the displacements of second order
/// (fe/elements/turning_cell.h). Of all their combinations those of the largest energies are kept. Nothing
/// where they have none, as in a straight bar with one end held.
std::optional<Stretching> find_stretching(const StretchedMesh& stretched, std::vector<int> place_of_frame);

/// Of a body made of beams, not yet orthogonal.
std::optional<Stretching> stretching_of_beams(const Mesh& mesh, const Matrices& matrices,
                                              const ReductionOptions& options,
                                              const std::vector<NodeFrame>& frames,
                                              const Eigen::MatrixXd& shapes, const ReducedBody& body);

class TiedModel;
struct Shapes;

/// Of any other mesh, likewise. `all`: the matrices of the whole mesh, `left` those of the dofs that are left
/// where equations hold, which `tied` and `shapes` are of (the same without any).
std::optional<Stretching> stretching_of_mesh(const SolidMesh& mesh, const FeMatrices& all,
                                             const FeMatrices& left, const std::vector<Interface>& interfaces,
                                             const TiedModel& tied, const Shapes& shapes,
                                             const ReducedBody& body);

}  // namespace fe
}  // namespace mimbre
