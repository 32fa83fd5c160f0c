#include "reduction/bases/effective_mass.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "math/once/decompositions.h"
#include "reduction/bases/shapes.h"

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kNone = 0.1;  // %: less effective mass is not worth a mode

VectorXd eigenvalues(const MatrixXd& stiffness, const MatrixXd& mass) {
  const VectorXd unit = mass.diagonal().cwiseSqrt().cwiseInverse();  // metres and radians must not meet
  return symmetric_eigenvalues(unit.asDiagonal() * stiffness * unit.asDiagonal(),
                               unit.asDiagonal() * mass * unit.asDiagonal());
}

}  // namespace

MatrixXd effective_mass(const FeMatrices& matrices, const Interface& interface, const MatrixXd& R,
                        const MatrixXd& modes) {
  MatrixXd axes = MatrixXd::Zero(6, 6);
  axes.topLeftCorner<3, 3>() = axes.bottomRightCorner<3, 3>() = interface.axes;
  const MatrixXd rigid = R * solve(rigid_points({interface}), axes);
  const MatrixXd momenta = symmetric_times(matrices.mass, rigid);
  const VectorXd whole = rigid.cwiseProduct(momenta).colwise().sum();
  return 100 * (whole.cwiseInverse().asDiagonal() * (momenta.transpose() * modes).cwiseAbs2());
}

ModeSelection select_modes(const MatrixXd& effective_mass, double percent) {
  const Index modes = effective_mass.cols();
  std::vector<char> taken(static_cast<std::size_t>(modes), 0);
  ModeSelection selection;
  for (Index direction = 0; direction < 6; ++direction) {
    const auto share = [&](Index k) { return effective_mass(direction, k); };
    std::vector<Index> order(static_cast<std::size_t>(modes));
    std::iota(order.begin(), order.end(), Index{0});
    std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return share(a) > share(b); });
    const bool reachable = effective_mass.row(direction).sum() >= percent;
    double sum = 0;
    for (const Index k : order) {
      if (reachable ? sum >= percent : share(k) < kNone) break;
      taken[static_cast<std::size_t>(k)] = 1;
      sum += share(k);
    }
    selection.reached = selection.reached && reachable;
  }
  selection.share.setZero();
  for (Index k = 0; k < modes; ++k) {
    const bool keep = taken[static_cast<std::size_t>(k)] != 0;
    (keep ? selection.kept : selection.dropped).push_back(k);
    if (keep) selection.share += effective_mass.col(k);
  }
  return selection;
}

double frequency_rise(const MatrixXd& stiffness, const MatrixXd& mass, const std::vector<Index>& kept) {
  const VectorXd all = eigenvalues(stiffness, mass),
                 some = eigenvalues(stiffness(kept, kept), mass(kept, kept));
  double rise = 0;
  for (Index k = 6; k < std::min<Index>(12, some.size()); ++k)
    rise = std::max(rise, std::sqrt(some[k] / all[k]) - 1);
  return rise;
}

}  // namespace mimbre::fe
