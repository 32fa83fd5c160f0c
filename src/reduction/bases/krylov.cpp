#include "reduction/bases/krylov.h"
#include "math/once/decompositions.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <memory>
#include <stdexcept>

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Static modes combined so that each is a mode of the condensed model (Guyan 1965), scaled by how much it
/// moves at low frequencies.
MatrixXd weighted_motions(const FeMatrices& matrices, const MatrixXd& statics) {
  const MatrixXd mass = statics.transpose() * symmetric_times(matrices.mass, statics),
                 stiffness = statics.transpose() * symmetric_times(matrices.stiffness, statics);
  const VectorXd unit = mass.diagonal().cwiseSqrt().cwiseInverse();
  const EigenPairs condensed = symmetric_eigen(unit.asDiagonal() * stiffness * unit.asDiagonal(),
                                               unit.asDiagonal() * mass * unit.asDiagonal());
  VectorXd weight = VectorXd::Ones(mass.cols());
  if (mass.cols() > 6) {
    const VectorXd& squares = condensed.values;
    weight = (squares.cwiseMax(0).array() / squares[6] + 1).inverse();
  }
  return statics * (unit.asDiagonal() * condensed.vectors * weight.asDiagonal());
}

/// (Txᵀ (K − shift M) Tx)⁻¹.
class ShiftedModel {
 public:
  ShiftedModel(const SolidMesh& mesh, const TiedModel& tied, const FeMatrices& matrices,
               const std::vector<Interface>& interfaces, double shift)
      : tied_(tied) {
    if (shift == 0) return;
    matrices_ = {matrices.mass, matrices.stiffness - shift * matrices.mass, matrices.dofs};
    own_ = std::make_unique<TiedModel>(mesh, matrices_, interfaces, Definiteness::any);
  }
  MatrixXd solve(const MatrixXd& f) const {
    if (!own_) return tied_.solve(f);
    MatrixXd x = own_->solve(f);
    x += own_->solve(f - apply(x));  // factors without pivots lose digits
    if (!((f - apply(x)).norm() < 1e-6 * f.norm()))
      throw std::invalid_argument(
          "the frequency of the Krylov basis is one of the held model's own: choose another");
    return x;
  }

 private:
  MatrixXd apply(const MatrixXd& x) const {
    const MatrixXd u = own_->expand(x, MatrixXd::Zero(own_->boundaries(), x.cols()));
    return own_->restrict(symmetric_times(matrices_.stiffness, u));
  }
  const TiedModel& tied_;
  FeMatrices matrices_;
  std::unique_ptr<TiedModel> own_;
};

}  // namespace

MatrixXd krylov_vectors(const SolidMesh& mesh, const TiedModel& tied, const FeMatrices& matrices,
                        const std::vector<Interface>& interfaces, double shift, int count) {
  constexpr double least = 1e-12;  // of a block's energy: less is round-off
  const ShiftedModel shifted(mesh, tied, matrices, interfaces, shift);
  const Pencil held = tied.held();
  const auto stiffness = [&](const MatrixXd& x) {
    return tied.restrict(
        symmetric_times(matrices.stiffness, tied.expand(x, MatrixXd::Zero(tied.boundaries(), x.cols()))));
  };
  const MatrixXd motions = weighted_motions(matrices, static_shapes(tied, matrices, interfaces, 0).dofs);
  MatrixXd block = shifted.solve(tied.restrict(symmetric_times(matrices.mass, motions)));
  MatrixXd basis(tied.internals(), std::min<Index>(count, tied.internals()));
  Index found = 0;
  while (found < basis.cols()) {
    const double before = block.cwiseProduct(stiffness(block)).colwise().sum().maxCoeff();
    const auto known = basis.leftCols(found);
    for (int pass = 0; pass < 2; ++pass) block -= known * (known.transpose() * stiffness(block));
    const MatrixXd gram = block.transpose() * stiffness(block);
    const EigenPairs energies = symmetric_eigen(0.5 * (gram + gram.transpose()));
    const Index fresh = (energies.values.array() > least * before).count();
    if (fresh == 0) break;
    const VectorXd energy = energies.values.tail(fresh).reverse();
    block = (block * energies.vectors.rightCols(fresh).rowwise().reverse()).eval();
    const Index taken = std::min(fresh, basis.cols() - found);
    basis.middleCols(found, taken) =
        block.leftCols(taken) * energy.head(taken).cwiseSqrt().cwiseInverse().asDiagonal();
    found += taken;
    if (found < basis.cols()) block = shifted.solve(held.mass(block));
  }
  return basis.leftCols(found);
}

}  // namespace mimbre::fe
