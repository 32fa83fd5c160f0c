#include "reduction/bases/user_modes.h"
#include "math/once/decompositions.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <map>
#include <stdexcept>
#include <utility>

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double misfit_limit = 0.1;

/// Row of the model of each given displacement.
std::vector<Index> rows_of(const FeMatrices& matrices, const UserModes& modes) {
  if (modes.shapes.rows() != static_cast<Index>(modes.dofs.size()))
    throw std::invalid_argument(
        fmt::format("the user's modes have {} rows for {} dofs", modes.shapes.rows(), modes.dofs.size()));
  if (!modes.shapes.allFinite())
    throw std::invalid_argument("the user's modes have numbers that are not finite");
  for (Index k = 0; k < modes.shapes.cols(); ++k)
    if (modes.shapes.col(k).isZero(0))
      throw std::invalid_argument(fmt::format("the user's mode {} moves nothing", k + 1));
  std::map<std::pair<int, int>, Index> all;
  for (std::size_t r = 0; r < matrices.dofs.size(); ++r)
    all.emplace(std::pair(matrices.dofs[r].node, matrices.dofs[r].direction), static_cast<Index>(r));
  std::vector<Index> rows;
  for (const Dof& dof : modes.dofs) {
    const auto found = all.find({dof.node, dof.direction});
    if (found == all.end())
      throw std::invalid_argument(
          "the user's modes have a displacement where the model has none, or have it twice");
    rows.push_back(found->second);
    all.erase(found);
  }
  return rows;
}

}  // namespace

ExpandedModes expand_user_modes(const SolidMesh& mesh, const FeMatrices& matrices,
                                const std::vector<Interface>& interfaces, const UserModes& modes) {
  constexpr double stiff = 1e6, least = 1e-11;
  const std::vector<Index> rows = rows_of(matrices, modes);
  const VectorXd own = matrices.stiffness.diagonal();
  const double floor = 1e-6 * own.maxCoeff();
  std::vector<Eigen::Triplet<double>> entries;
  MatrixXd forces = MatrixXd::Zero(own.size(), modes.shapes.cols());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double spring = stiff * std::max(own[rows[k]], floor);
    entries.emplace_back(rows[k], rows[k], spring);
    forces.row(rows[k]) = spring * modes.shapes.row(static_cast<Index>(k));
  }
  Eigen::SparseMatrix<double> springs(own.size(), own.size());
  springs.setFromTriplets(entries.begin(), entries.end());
  const FeMatrices held{matrices.mass, matrices.stiffness + springs, matrices.dofs};
  const TiedModel tied(mesh, held, interfaces);

  // Shapes with the interfaces held, then the interfaces' motion: the two are orthogonal by the stiffness.
  const MatrixXd statics = static_shapes(tied, held, interfaces, 0).dofs;
  MatrixXd stiffness = statics.transpose() * symmetric_times(held.stiffness, statics);
  const VectorXd unit = stiffness.diagonal().cwiseSqrt().cwiseInverse();
  stiffness = (unit.asDiagonal() * stiffness * unit.asDiagonal()).eval();
  stiffness = (0.5 * (stiffness + stiffness.transpose())).eval();
  if (symmetric_eigenvalues(stiffness)[0] < least)
    throw std::invalid_argument(
        "the user's modes are not sufficient: displacements of at least three nodes that do not lie in a "
        "line are needed, in directions that no rigid motion leaves out");
  ExpandedModes expanded;
  expanded.z = unit.asDiagonal() *
               PivotedCholesky(stiffness).solve(unit.asDiagonal() * (statics.transpose() * forces));
  expanded.u =
      tied.expand(tied.solve(tied.restrict(forces)), MatrixXd::Zero(tied.boundaries(), forces.cols())) +
      statics * expanded.z;
  expanded.misfit.resize(modes.shapes.cols());
  for (Index k = 0; k < modes.shapes.cols(); ++k) {
    double square = 0;
    for (std::size_t r = 0; r < rows.size(); ++r)
      square += std::pow(expanded.u(rows[r], k) - modes.shapes(static_cast<Index>(r), k), 2);
    expanded.misfit[k] = std::sqrt(square) / modes.shapes.col(k).norm();
  }
  return expanded;
}

Shapes held_user_modes(const TiedModel& tied, const FeMatrices& matrices,
                       const std::vector<Interface>& interfaces, const ExpandedModes& modes) {
  Shapes shapes{modes.u - static_shapes(tied, matrices, interfaces, 0).dofs * modes.z,
                MatrixXd::Zero(modes.z.rows(), modes.z.cols()),
                {}};
  for (Index k = 0; k < modes.u.cols(); ++k) shapes.names.push_back(fmt::format("user {}", k + 1));
  return shapes;
}

Shapes free_user_modes(const FeMatrices& matrices, const std::vector<Interface>& interfaces,
                       const MatrixXd& R, const ExpandedModes& modes) {
  const MatrixXd momenta = symmetric_times(matrices.mass, R);
  const MatrixXd part = PivotedCholesky(R.transpose() * momenta).solve(momenta.transpose() * modes.u);
  Shapes shapes{modes.u - R * part, point_rows(interfaces, modes.z) - rigid_points(interfaces) * part, {}};
  for (Index k = 0; k < modes.u.cols(); ++k) shapes.names.push_back(fmt::format("user {}", k + 1));
  return shapes;
}

Check user_modes_check(const FeMatrices& matrices, const UserModes& given, const ExpandedModes& modes,
                       const std::vector<double>& fresh) {
  const auto count = std::count_if(fresh.begin(), fresh.end(), [](double part) { return part > 0; });
  const double worst = modes.misfit.maxCoeff();
  return {"user modes", worst < misfit_limit,
          fmt::format("{} given at {} of {} dofs, {} new; the shapes have the displacements given to {:.2g} %"
                      "{}",
                      given.shapes.cols(), given.dofs.size(), matrices.dofs.size(), count, 100 * worst,
                      worst < misfit_limit ? "" : ", for these contradict the interfaces")};
}

}  // namespace mimbre::fe
