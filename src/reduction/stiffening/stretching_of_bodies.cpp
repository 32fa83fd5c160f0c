#include <algorithm>

#include "fe/solve/symmetric_solver.h"
#include "math/once/decompositions.h"
#include "reduction/bases/shapes.h"
#include "reduction/stiffening/stretching.h"
#include "reduction/tied_model.h"

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Modes whose pairs the states of stress are of. Bars cost nothing; of a mesh each pair takes a solution.
constexpr Index most_of_beams = 6, most_of_mesh = 4;

/// Of unit stiffness, as many as there are.
MatrixXd lowest_modes(const ReducedBody& body, Index count) {
  if (body.modes == 0) return MatrixXd(0, 0);
  const EigenPairs pairs = symmetric_eigen(body.stiffness, body.mass_matrix);
  const Index all = pairs.values.size();
  Index free = 0;
  while (free < all && !(pairs.values[free] > 1e-12 * pairs.values[all - 1])) ++free;
  count = std::min(count, all - free);
  return pairs.vectors.middleCols(free, count) *
         pairs.values.segment(free, count).cwiseSqrt().cwiseInverse().asDiagonal();
}

std::vector<int> first_dofs(const SolidMesh& mesh, const std::vector<Dof>& dofs) {
  std::vector<int> first(static_cast<std::size_t>(mesh.nodes.cols()), -1);
  for (std::size_t r = dofs.size(); r-- > 0;)
    first[static_cast<std::size_t>(dofs[r].node)] = static_cast<int>(r);
  return first;
}

/// Interfaces that move as one rigid body, and the mesh's own rigid parts.
std::vector<RigidNodes> rigid_nodes(const SolidMesh& mesh, const std::vector<Interface>& interfaces,
                                    const MatrixXd& points, const MatrixXd& shapes,
                                    const std::vector<Dof>& dofs, const std::vector<int>& first) {
  const auto known = [&](std::vector<int> nodes) {
    std::erase_if(nodes, [&](int node) { return first[static_cast<std::size_t>(node)] < 0; });
    return nodes;
  };
  std::vector<RigidNodes> rigid;
  for (std::size_t i = 0; i < interfaces.size(); ++i)
    if (interfaces[i].tie == Interface::Tie::rigid)
      rigid.push_back({known(interfaces[i].nodes), interfaces[i].point,
                       points.middleRows<3>(static_cast<Index>(6 * i + 3))});
  for (const RigidElement& element : mesh.rigid_elements) {
    const int row = first[static_cast<std::size_t>(element.reference)];
    const bool turns = row >= 0 && static_cast<std::size_t>(row) + 5 < dofs.size() &&
                       dofs[static_cast<std::size_t>(row) + 5].node == element.reference;
    if (turns && element.follows[0] && element.follows[1] && element.follows[2])
      rigid.push_back(
          {known(element.nodes), mesh.nodes.col(element.reference), shapes.middleRows<3>(row + 3)});
  }
  return rigid;
}

}  // namespace

std::optional<Stretching> stretching_of_mesh(const SolidMesh& mesh, const FeMatrices& all,
                                             const FeMatrices& left, const std::vector<Interface>& interfaces,
                                             const TiedModel& tied, const Shapes& shapes,
                                             const ReducedBody& body) {
  if (!all.of_mesh) return {};
  const bool constrained = left.expansion.size() > 0;
  const auto expanded = [&](const MatrixXd& u) -> MatrixXd { return constrained ? left.expansion * u : u; };
  MatrixXd z = MatrixXd::Zero(tied.boundaries(), tied.boundaries());
  for (std::size_t i = 0; i < interfaces.size(); ++i)
    for (const auto at : {static_cast<Index>(6 * i), static_cast<Index>(6 * i + 3)})
      z.block<3, 3>(at, at) = interfaces[i].axes.transpose();
  StretchedMesh stretched{mesh,
                          all.stiffness,
                          first_dofs(mesh, all.dofs),
                          expanded(shapes.dofs),
                          lowest_modes(body, most_of_mesh),
                          {},
                          expanded(tied.expand(MatrixXd::Zero(tied.internals(), z.cols()), z)),
                          [&](const MatrixXd& forces) -> MatrixXd {
                            const MatrixXd x = tied.solve(
                                tied.restrict(constrained ? left.expansion.transpose() * forces : forces));
                            return expanded(tied.expand(x, MatrixXd::Zero(tied.boundaries(), x.cols())));
                          }};
  stretched.rigid =
      rigid_nodes(mesh, interfaces, shapes.points, stretched.shapes, all.dofs, stretched.first_dof);
  std::vector<int> places;
  for (std::size_t i = 0; i < interfaces.size(); ++i) places.push_back(static_cast<int>(i));
  return find_stretching(stretched, places);
}

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
  return find_stretching({whole,
                          matrices.stiffness,
                          first,
                          shapes,
                          lowest_modes(body, most_of_beams),
                          {},
                          unit_motions,
                          respond},
                         place_of_frame);
}

}  // namespace mimbre::fe
