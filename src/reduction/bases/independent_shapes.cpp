#include "reduction/bases/independent_shapes.h"
#include "math/once/decompositions.h"

#include <Eigen/Core>
#include <cmath>

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Takes the part in `known` out, orthogonally by K; scaled, so that metres and radians do not meet.
void remove(const FeMatrices& matrices, const MatrixXd& dofs, const MatrixXd& points, Shapes& shapes) {
  if (dofs.cols() == 0) return;
  const MatrixXd forces = symmetric_times(matrices.stiffness, dofs);
  MatrixXd gram = dofs.transpose() * forces;
  const VectorXd unit = gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  gram = (unit.asDiagonal() * gram * unit.asDiagonal()).eval();
  const PivotedCholesky factor(0.5 * (gram + gram.transpose()));
  for (int pass = 0; pass < 2; ++pass) {  // once leaves round-off of what was large
    const MatrixXd part =
        unit.asDiagonal() * factor.solve(unit.asDiagonal() * (forces.transpose() * shapes.dofs));
    shapes.dofs -= dofs * part;
    shapes.points -= points * part;
  }
}

}  // namespace

Shapes independent_shapes(const FeMatrices& matrices, const Shapes& known, Shapes added,
                          std::vector<double>& fresh) {
  constexpr double least = 1e-12;  // of the strain energy
  const auto energies = [&](const MatrixXd& u) {
    return VectorXd(u.cwiseProduct(symmetric_times(matrices.stiffness, u)).colwise().sum());
  };
  const VectorXd before = energies(added.dofs);
  remove(matrices, known.dofs, known.points, added);
  fresh.assign(static_cast<std::size_t>(added.dofs.cols()), 0.0);
  Shapes kept{MatrixXd(added.dofs.rows(), 0), MatrixXd(added.points.rows(), 0), {}};
  for (Index k = 0; k < added.dofs.cols(); ++k) {
    Shapes one{added.dofs.col(k), added.points.col(k), {added.names[static_cast<std::size_t>(k)]}};
    remove(matrices, kept.dofs, kept.points, one);
    const double energy = energies(one.dofs)[0];
    if (!(energy > least * before[k])) continue;
    fresh[static_cast<std::size_t>(k)] = energy / before[k];
    const double scale = 1 / std::sqrt(one.dofs.cwiseProduct(symmetric_times(matrices.mass, one.dofs)).sum());
    one.dofs *= scale;
    one.points *= scale;
    kept = join(kept, one);
  }
  return kept;
}

}  // namespace mimbre::fe
