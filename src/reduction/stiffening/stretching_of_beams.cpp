#include <algorithm>

#include "fe/solve/symmetric_solver.h"
#include "reduction/stiffening/stretching.h"

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Modes whose pairs the states of stress are of: of bars they cost nothing.
constexpr Index most_of_beams = 6;

}  // namespace

std::optional<Stretching> stretching_of_beams(const Mesh& mesh, const Matrices& matrices,
                                              const ReductionOptions& options,
                                              const std::vector<NodeFrame>& frames, const MatrixXd& shapes,
                                              const ReducedBody& body) {
  std::vector<int> places, place_of_frame;
  const auto place = [&](int node) {
    const auto at = std::find(places.begin(), places.end(), node);
    const auto number = static_cast<int>(at - places.begin());
    if (at == places.end()) places.push_back(node);
    return number;
  };
  for (const NodeFrame& frame : frames) place_of_frame.push_back(place(frame.node));
  for (const int node : options.clamped_nodes) place(node);

  SolidMesh whole;
  whole.nodes = mesh.nodes;
  whole.beams = mesh.elements;
  const Index dofs = shapes.rows();
  std::vector<int> first;
  for (int node = 0; node < mesh.nodes.cols(); ++node) first.push_back(6 * node);
  MatrixXd unit_motions = MatrixXd::Zero(dofs, 6 * static_cast<Index>(places.size()));
  std::vector<bool> held(static_cast<std::size_t>(dofs), false);
  for (const int dof : options.fixed_dofs) held[static_cast<std::size_t>(dof)] = true;
  for (std::size_t k = 0; k < places.size(); ++k)
    for (Index d = 0; d < 6; ++d) {
      unit_motions(6 * places[k] + d, static_cast<Index>(6 * k) + d) = 1;
      held[static_cast<std::size_t>(6 * places[k] + d)] = true;
    }
  std::vector<Eigen::Triplet<double>> triplets;
  int internals = 0;
  for (int dof = 0; dof < dofs; ++dof)
    if (!held[static_cast<std::size_t>(dof)]) triplets.emplace_back(dof, internals++, 1.0);
  Eigen::SparseMatrix<double> internal(dofs, internals);
  internal.setFromTriplets(triplets.begin(), triplets.end());
  const Eigen::SparseMatrix<double> inner = internal.transpose() * matrices.stiffness * internal;
  const SymmetricSolver factor(inner);
  const auto respond = [&](const MatrixXd& forces) -> MatrixXd {
    if (internals == 0) return MatrixXd::Zero(forces.rows(), forces.cols());
    return internal * factor.solve(internal.transpose() * forces).eval();
  };
  if (internals > 0 && !factor.ok()) return {};
  return find_stretching(
      {whole,
       matrices.stiffness,
       first,
       shapes,
       lowest_amplitudes(body, most_of_beams),
       {},
       unit_motions,
       respond,
       [](const MeshCells&, const Mesh& beams, int number) { return turning_beam(beams, number); }},
      place_of_frame);
}

}  // namespace mimbre::fe
