#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "fe/elements/beam_element.h"
#include "fe/rigid_motion.h"
#include "fe/solve/lowest_modes.h"
#include "math/elementary.h"
#include "mimbre/fe.h"

namespace mimbre::fe {
namespace {

/// Columns of the identity: one for each dof whose flag equals `wanted`.
Eigen::SparseMatrix<double> selection(const std::vector<bool>& flags, bool wanted) {
  std::vector<Eigen::Triplet<double>> ones;
  for (int dof = 0; dof < static_cast<int>(flags.size()); ++dof)
    if (flags[dof] == wanted) ones.emplace_back(dof, static_cast<int>(ones.size()), 1.0);
  Eigen::SparseMatrix<double> matrix(static_cast<Eigen::Index>(flags.size()),
                                     static_cast<Eigen::Index>(ones.size()));
  matrix.setFromTriplets(ones.begin(), ones.end());
  return matrix;
}

/// A shift for meshes that can move rigidly: minus about the lowest bending eigenvalue that a straight beam
/// as long as the whole mesh would have, but large enough that K − shift·M is safely positive definite.
double rigid_motion_shift(const Mesh& mesh, const Matrices& matrices) {
  double length = 0;
  double softest = std::numeric_limits<double>::infinity();
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const BeamElement& beam = mesh.elements[e];
    length += element_geometry(mesh, e).length;
    softest = std::min(softest, beam.material.young * std::min(beam.section.Iy, beam.section.Iz) /
                                    (beam.material.density * beam.section.area));
  }
  const Eigen::ArrayXd masses = matrices.mass.diagonal();
  const Eigen::ArrayXd stiffnesses = matrices.stiffness.diagonal();
  const double highest = (masses > 0).select(stiffnesses / masses, 0.0).maxCoeff();
  return -std::max(softest * mimbre::pow(std::numbers::pi / length, 4), 1e-12 * highest);
}

}  // namespace

Eigen::VectorXd eigenfrequencies_fixed_dofs(const Mesh& mesh, const std::vector<int>& fixed_dofs, int count) {
  const int dofs = static_cast<int>(6 * mesh.nodes.cols());
  std::vector<bool> fixed(dofs, false);
  for (int dof : fixed_dofs) {
    if (dof < 0 || dof >= dofs)
      throw std::invalid_argument(fmt::format("fixed dof {} does not exist, the mesh has {}", dof, dofs));
    fixed[dof] = true;
  }
  const Matrices matrices = assemble(mesh);
  for (int dof = 0; dof < dofs; ++dof)
    if (!fixed[dof] && matrices.mass.coeff(dof, dof) == 0)
      throw std::invalid_argument(fmt::format("node {} belongs to no element", dof / 6));

  const Eigen::SparseMatrix<double> free = selection(fixed, false);
  if (count < 0 || count > free.cols())
    throw std::invalid_argument(
        fmt::format("{} eigenfrequencies asked of a mesh with {} free dofs", count, free.cols()));
  if (count == 0) return {};
  const int rigid = free_rigid_motions(mesh, selection(fixed, true)).count;
  const double shift = rigid > 0 ? rigid_motion_shift(mesh, matrices) : 0;
  const Eigen::SparseMatrix<double> K = free.transpose() * matrices.stiffness * free;
  const Eigen::SparseMatrix<double> M = free.transpose() * matrices.mass * free;
  const SymmetricSolver factor(K - shift * M);
  if (!factor.ok()) throw std::runtime_error("the stiffness matrix could not be factorised");

  Eigen::VectorXd eigenvalues = lowest_modes(M, count, shift, factor).eigenvalues;
  eigenvalues.head(std::min(rigid, count)).setZero();
  return eigenvalues.cwiseMax(0).cwiseSqrt();
}

Eigen::VectorXd eigenfrequencies(const Mesh& mesh, const std::vector<int>& clamped_nodes, int count) {
  std::vector<int> dofs;
  for (int node : clamped_nodes)
    for (int k = 0; k < 6; ++k) dofs.push_back(6 * node + k);
  return eigenfrequencies_fixed_dofs(mesh, dofs, count);
}

}  // namespace mimbre::fe
