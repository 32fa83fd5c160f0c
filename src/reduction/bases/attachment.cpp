#include "reduction/bases/attachment.h"
#include "math/once/decompositions.h"

#include <Eigen/Core>

namespace mimbre::fe {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd attached_eigenmodes(const TiedModel& tied, const FeMatrices& matrices,
                             const std::vector<Interface>& interfaces, int modes, double limit,
                             VectorXd& eigenvalues, const std::function<void(double)>& progress) {
  // K⁻¹ with the first interface held: with all of them held, and what the static modes add.
  const MatrixXd statics = static_shapes(tied, matrices, interfaces, 1).dofs;
  Cholesky stiffness;
  if (statics.cols() > 0)
    stiffness = Cholesky(statics.transpose() * symmetric_times(matrices.stiffness, statics));
  const auto internal = [&](const MatrixXd& f) { return tied.solve(tied.restrict(f)); };
  Pencil pencil;
  pencil.size = tied.internals() + statics.cols();
  pencil.rows = matrices.stiffness.rows();
  pencil.solve = [&](const MatrixXd& f) {
    MatrixXd u = tied.expand(internal(f), MatrixXd::Zero(tied.boundaries(), f.cols()));
    if (statics.cols() > 0) u += statics * stiffness.solve(statics.transpose() * f);
    return u;
  };
  pencil.mass = [&](const MatrixXd& u) { return symmetric_times(matrices.mass, u); };
  const Modes found =
      limit > 0 ? block_lanczos_below(pencil, limit, progress) : block_lanczos(pencil, modes, progress);
  eigenvalues = found.eigenvalues;
  return internal(pencil.mass(found.vectors) * eigenvalues.asDiagonal());
}

MatrixXd inertia_responses(const TiedModel& tied, const FeMatrices& matrices, const MatrixXd& R) {
  return tied.solve(tied.restrict(symmetric_times(matrices.mass, R)));
}

}  // namespace mimbre::fe
