#include "reduction/bases/free_interface.h"
#include "math/once/decompositions.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Displacements of dofs and the interfaces' coordinates z.
struct Response {
  MatrixXd u, z;
};

/// What loads do to the free body beside accelerating it: flexibility by inertia relief, Pᵀ K⁻¹ P with the
/// first interface held in K⁻¹ and P = 1 − M R (Rᵀ M R)⁻¹ Rᵀ, which leaves the hold no reaction.
class FreeFlexibility {
 public:
  FreeFlexibility(const TiedModel& tied, const FeMatrices& matrices, const std::vector<Interface>& interfaces,
                  const MatrixXd& R)
      : tied_(tied), R_(R), MR_(symmetric_times(matrices.mass, R)), inertia_(R.transpose() * MR_) {
    rigid_z_ = rigid_points(interfaces);
    for (std::size_t i = 0; i < interfaces.size(); ++i)
      for (Index row = static_cast<Index>(6 * i), half = 0; half < 2; ++half, row += 3)
        rigid_z_.middleRows<3>(row) = interfaces[i].axes.transpose() * rigid_z_.middleRows<3>(row).eval();
    statics_ = static_shapes(tied, matrices, interfaces, 1).dofs;
    if (statics_.cols() > 0)
      stiffness_ = Cholesky(statics_.transpose() * symmetric_times(matrices.stiffness, statics_));
  }

  /// Loads on the dofs, and on the interfaces' coordinates.
  Response respond(const MatrixXd& loads, const MatrixXd& interface_loads) const {
    const MatrixXd acceleration =
        inertia_.solve(R_.transpose() * loads + rigid_z_.transpose() * interface_loads);
    const MatrixXd f = loads - MR_ * acceleration;
    Response r{tied_.expand(tied_.solve(tied_.restrict(f)), MatrixXd::Zero(tied_.boundaries(), f.cols())),
               MatrixXd::Zero(tied_.boundaries(), f.cols())};
    if (const Index count = statics_.cols(); count > 0) {
      r.z.bottomRows(count) = stiffness_.solve(statics_.transpose() * f + interface_loads.bottomRows(count));
      r.u += statics_ * r.z.bottomRows(count);
    }
    const MatrixXd rigid = inertia_.solve(MR_.transpose() * r.u);
    r.u -= R_ * rigid;
    r.z -= rigid_z_ * rigid;
    return r;
  }

 private:
  const TiedModel& tied_;
  const MatrixXd& R_;
  MatrixXd MR_;
  PivotedCholesky inertia_;
  MatrixXd rigid_z_, statics_;
  Cholesky stiffness_;
};

/// Columns that are independent of those before them, by Cholesky's factors with pivots: gram has a unit
/// diagonal.
std::vector<Index> independent(MatrixXd gram) {
  constexpr double least = 1e-10;  // of the square of the part that is new
  std::vector<Index> kept;
  for (Index next = 0; gram.diagonal().maxCoeff(&next) > least;) {
    kept.push_back(next);
    gram -= (gram.col(next) * gram.row(next) / gram(next, next)).eval();
    for (const Index k : kept) gram(k, k) = 0;
  }
  std::sort(kept.begin(), kept.end());
  return kept;
}

}  // namespace

Shapes free_interface_shapes(const TiedModel& tied, const FeMatrices& matrices,
                             const std::vector<Interface>& interfaces, const MatrixXd& R, int modes,
                             double limit, const MatrixXd& loads, const std::vector<std::string>& load_names,
                             VectorXd& eigenvalues, const std::function<void(double)>& progress) {
  const FreeFlexibility flexibility(tied, matrices, interfaces, R);
  const auto respond = [&](const MatrixXd& f) {
    return flexibility.respond(f, MatrixXd::Zero(tied.boundaries(), f.cols()));
  };
  Pencil pencil;
  pencil.size = tied.internals() + tied.boundaries() - 6;
  pencil.rows = matrices.stiffness.rows();
  pencil.solve = [&](const MatrixXd& f) { return respond(f).u; };
  pencil.mass = [&](const MatrixXd& u) { return symmetric_times(matrices.mass, u); };
  const Modes found =
      limit > 0 ? block_lanczos_below(pencil, limit, progress) : block_lanczos(pencil, modes, progress);
  eigenvalues = found.eigenvalues;
  const Index count = eigenvalues.size(), boundaries = tied.boundaries(), forces = boundaries + loads.cols();
  // One more iteration gives the motion of the interfaces too.
  Response free = respond(pencil.mass(found.vectors) * eigenvalues.asDiagonal());

  MatrixXd on_dofs = MatrixXd::Zero(pencil.rows, forces);
  on_dofs.rightCols(loads.cols()) = loads;
  Response residual = flexibility.respond(on_dofs, MatrixXd::Identity(boundaries, forces));
  const VectorXd all = (residual.u.transpose() * pencil.mass(residual.u)).diagonal();
  MatrixXd known(count, forces);
  known << free.z.transpose(), free.u.transpose() * loads;
  known = (eigenvalues.cwiseInverse().asDiagonal() * known).eval();
  residual.u -= free.u * known;
  residual.z -= free.z * known;
  MatrixXd gram = residual.u.transpose() * pencil.mass(residual.u);
  VectorXd unit = gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  for (Index k = 0; k < forces; ++k)
    if (gram(k, k) < 1e-14 * all[k]) unit[k] = 0;  // round-off
  gram = (unit.asDiagonal() * gram * unit.asDiagonal()).eval();
  const std::vector<Index> kept = independent(gram);

  const auto residuals = static_cast<Index>(kept.size());
  std::vector<std::string> names = motion_names("residual", interfaces, 0);
  names.insert(names.end(), load_names.begin(), load_names.end());
  Shapes shapes{MatrixXd(pencil.rows, count + residuals), {}, {}};
  MatrixXd z(boundaries, count + residuals);
  shapes.dofs.leftCols(count) = free.u;
  z.leftCols(count) = free.z;
  for (Index k = 0; k < count; ++k) shapes.names.push_back(fmt::format("free {}", k + 1));
  for (Index k = 0; k < residuals; ++k) {
    const Index column = kept[static_cast<std::size_t>(k)];
    shapes.dofs.col(count + k) = unit[column] * residual.u.col(column);
    z.col(count + k) = unit[column] * residual.z.col(column);
    shapes.names.push_back(names[static_cast<std::size_t>(column)]);
  }
  shapes.points = point_rows(interfaces, z);
  return shapes;
}

}  // namespace mimbre::fe
