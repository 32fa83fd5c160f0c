#include "integrate/partition.h"
#include "math/once/decompositions.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace mimbre {

constexpr double redundant = 1e-7;  // pivot, as a share of the equation's largest coefficient
constexpr double open = 1e-3;       // the same for equations that were redundant at first
/// Of the largest weighted coefficient, or of 1 where that is more: an equation whose own are all smaller is
/// judged as if it had this one, so that round-off is no equation.
constexpr double empty = 1e-6;
constexpr double weak = 0.1;  // pivot, as a share of what it was where the choice was made

Partition::Partition(int coordinates, int equations)
    : n_(coordinates),
      m_(equations),
      equation_(equations),
      coordinate_(coordinates),
      lu_(equations, coordinates),
      pivot_(equations),
      largest_(equations),
      work_(equations) {
  std::iota(equation_.begin(), equation_.end(), 0);
  std::iota(coordinate_.begin(), coordinate_.end(), 0);
}

bool Partition::choose(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& row_weight,
                       const Eigen::VectorXd& column_weight) {
  std::iota(equation_.begin(), equation_.end(), 0);
  std::iota(coordinate_.begin(), coordinate_.end(), 0);
  for (int c = 0; c < n_; ++c)
    for (int r = 0; r < m_; ++r) lu_(r, c) = row_weight[r] * jacobian(r, c) * column_weight[c];
  for (int r = 0; r < m_; ++r) largest_[r] = n_ > 0 ? lu_.row(r).cwiseAbs().maxCoeff() : 0;
  const double least = m_ > 0 ? empty * std::max(1.0, largest_.maxCoeff()) : 0;
  largest_ = largest_.cwiseMax(least);
  const int wanted = rank_;
  rank_ = 0;
  bool sound = true;
  for (int k = 0; k < std::min(m_, n_); ++k) {
    int row = -1, column = -1;
    double best = 0;
    for (int c = k; c < n_; ++c)
      for (int r = k; r < m_; ++r) {
        const double size = std::abs(lu_(r, c));
        if (size > best && size > (k == wanted ? open : redundant) * largest_[r])
          best = size, row = r, column = c;
      }
    if (k == wanted) {
      sound = row < 0;
      if (!sound) weakest_ = equation_[row];
      break;
    }
    if (row < 0) {
      sound = wanted < 0;
      if (!sound) weakest_ = equation_[k];
      break;
    }
    lu_.row(k).swap(lu_.row(row));
    lu_.col(k).swap(lu_.col(column));
    std::swap(largest_[k], largest_[row]);
    std::swap(equation_[k], equation_[row]);
    std::swap(coordinate_[k], coordinate_[column]);
    for (int r = k + 1; r < m_; ++r) {
      const double factor = lu_(r, k) / lu_(k, k);
      if (factor == 0) continue;
      for (int c = k; c < n_; ++c) lu_(r, c) -= factor * lu_(k, c);
    }
    ++rank_;
  }
  pivot_.setZero();
  factor(jacobian);
  for (int k = 0; k < rank_; ++k) pivot_[k] = lu_(k, k);
  if (wanted >= 0) rank_ = wanted;
  return sound;
}

bool Partition::factor(const Eigen::MatrixXd& jacobian) {
  for (int c = 0; c < n_; ++c)
    for (int k = 0; k < rank_; ++k) lu_(k, c) = jacobian(equation_[k], coordinate_[c]);
  double least = 2;
  for (int k = 0; k < rank_; ++k) {
    const double pivot = lu_(k, k);
    if (pivot_[k] != 0) {
      const double share = pivot / pivot_[k];
      if (!(share >= least)) least = share, weakest_ = equation_[k];
      if (!(share > 0)) return false;
    }
    for (int r = k + 1; r < rank_; ++r) lu_(r, k) /= pivot;
    for (int c = k + 1; c < n_; ++c) {
      const double u = lu_(k, c);
      if (u == 0) continue;
      for (int r = k + 1; r < rank_; ++r) lu_(r, c) -= lu_(r, k) * u;
    }
  }
  return least > weak;
}

void Partition::particular(const double* b, double* x) {
  for (int k = 0; k < rank_; ++k) work_[k] = b[equation_[k]];
  const auto lu = lu_.topLeftCorner(rank_, rank_);
  auto y = work_.head(rank_);
  lu.triangularView<Eigen::UnitLower>().solveInPlace(y);
  lu.triangularView<Eigen::Upper>().solveInPlace(y);
  std::fill(x, x + n_, 0.0);
  for (int k = 0; k < rank_; ++k) x[coordinate_[k]] = work_[k];
}

void Partition::multipliers(const double* b, double* y) {
  for (int k = 0; k < rank_; ++k) work_[k] = b[coordinate_[k]];
  const auto lu = lu_.topLeftCorner(rank_, rank_);
  auto x = work_.head(rank_);
  lu.transpose().triangularView<Eigen::Lower>().solveInPlace(x);
  lu.transpose().triangularView<Eigen::UnitUpper>().solveInPlace(x);
  std::fill(y, y + m_, 0.0);
  for (int k = 0; k < rank_; ++k) y[equation_[k]] = work_[k];
}

void Partition::null_space(Eigen::MatrixXd& R) {
  const int f = n_ - rank_;
  R.setZero(n_, f);
  auto dependents = lu_.block(0, rank_, rank_, f);
  lu_.topLeftCorner(rank_, rank_).triangularView<Eigen::Upper>().solveInPlace(dependents);
  for (int j = 0; j < f; ++j) {
    R(coordinate_[rank_ + j], j) = 1;
    for (int k = 0; k < rank_; ++k) R(coordinate_[k], j) = -dependents(k, j);
  }
}

}  // namespace mimbre
