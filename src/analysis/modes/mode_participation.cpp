#include "analysis/modes/mode_participation.h"
#include "math/once/decompositions.h"

#include <Eigen/Core>
#include <algorithm>
#include <stdexcept>

namespace mimbre {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Displacements of all frames by the modes: 3·frames × modes.
MatrixXd frame_shapes(const ReducedBody& body) {
  MatrixXd X(3 * body.frames.size(), body.modes);
  for (std::size_t i = 0; i < body.frames.size(); ++i)
    X.middleRows<3>(static_cast<Index>(3 * i)) = body.frames[i].X;
  return X;
}

}  // namespace

MatrixXd frame_deflections(const ReducedBody& body, const MatrixXd& amplitudes) {
  return frame_shapes(body) * amplitudes;
}

VectorXd deflection_scales(const MatrixXd& deflections) {
  constexpr double least = 0.01;
  VectorXd scales(deflections.rows() / 3);
  for (Index i = 0; i < scales.size(); ++i)
    scales[i] = deflections.cols() > 0 ? deflections.middleRows<3>(3 * i).colwise().norm().maxCoeff() : 0.0;
  if (scales.size() > 0) scales = scales.cwiseMax(least * scales.maxCoeff()).eval();
  return scales;
}

double deflection_error(const MatrixXd& differences, const VectorXd& scales) {
  double worst = 0;
  for (Index i = 0; i < scales.size(); ++i)
    if (scales[i] > 0)
      worst = std::max(worst, differences.middleRows<3>(3 * i).colwise().norm().mean() / scales[i]);
  return worst;
}

ModeRanking rank_modes(const ReducedBody& body, const MatrixXd& amplitudes) {
  const MatrixXd X = frame_shapes(body);
  const VectorXd scales = deflection_scales(X * amplitudes);
  ModeRanking ranking;
  ranking.error.setZero(body.modes + 1);
  ranking.participation.resize(body.modes);
  std::vector<int> left(static_cast<std::size_t>(body.modes));
  for (int k = 0; k < body.modes; ++k) {
    left[static_cast<std::size_t>(k)] = k;
    ranking.participation[k] = deflection_error(X.col(k) * amplitudes.row(k), scales);
  }
  MatrixXd lost = MatrixXd::Zero(X.rows(), amplitudes.cols());
  while (!left.empty()) {
    double least = INFINITY;
    std::size_t next = left.size() - 1;
    // The highest of those that matter as little as each other goes first.
    for (std::size_t i = left.size(); i-- > 0;) {
      const int k = left[i];
      const double error = deflection_error(lost + X.col(k) * amplitudes.row(k), scales);
      if (error >= least) continue;
      least = error;
      next = i;
    }
    const int k = left[next];
    lost += X.col(k) * amplitudes.row(k);
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(next));
    ranking.order.push_back(k);
    ranking.error[static_cast<Index>(left.size())] = deflection_error(lost, scales);
  }
  std::reverse(ranking.order.begin(), ranking.order.end());
  return ranking;
}

ModeCombinations combine_modes(const ReducedBody& body, const MatrixXd& amplitudes) {
  constexpr double round_off = 1e-14;  // of the largest share: squares of amplitudes
  const Cholesky factor(body.stiffness);
  if (!factor.ok()) throw std::invalid_argument("the modes' stiffness is not positive definite");
  const MatrixXd root = factor.lower().transpose() * amplitudes;
  const EigenPairs energies = symmetric_eigen(root * root.transpose());
  const VectorXd all = energies.values.reverse();
  if (!(all[0] > 0)) throw std::invalid_argument("the body does not deflect in this run");
  const Index count = (all.array() > round_off * all[0]).count();

  ModeCombinations combinations;
  const MatrixXd directions = energies.vectors.rowwise().reverse().leftCols(count);
  combinations.T = factor.solve_upper(directions);
  combinations.share = all.head(count) / all.cwiseMax(0).sum();
  combinations.error.resize(count + 1);
  combinations.participation.resize(count);
  const MatrixXd X = frame_shapes(body);
  MatrixXd lost = X * amplitudes;
  const VectorXd scales = deflection_scales(lost);
  combinations.error[0] = deflection_error(lost, scales);
  for (Index k = 0; k < count; ++k) {
    const MatrixXd part = X * combinations.T.col(k) * (directions.col(k).transpose() * root);
    combinations.participation[k] = deflection_error(part, scales);
    lost -= part;
    combinations.error[k + 1] = deflection_error(lost, scales);
  }
  return combinations;
}

}  // namespace mimbre
