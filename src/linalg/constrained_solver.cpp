#include "linalg/constrained_solver.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace mimbre::linalg {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// By which violations count, of the largest entry of H.
constexpr double penalty = 1e6;
/// Of the largest entry of 1/H, on the diagonal beside J: so that redundant rows have a multiplier.
constexpr double softness = 1e-9;
/// Of the right side: solved; and hardly.
constexpr double solved = 1e-14, roughly = 1e-4;
/// Of the largest entry: less comes of differences.
constexpr double not_symmetric = 1e-8;

bool same_matrix(const SparseMatrix& A, const SparseMatrix& B) {
  const auto same = [](const auto* a, const auto* b, Eigen::Index n) { return std::equal(a, a + n, b); };
  return A.isCompressed() && B.isCompressed() && A.rows() == B.rows() && A.cols() == B.cols() &&
         A.nonZeros() == B.nonZeros() && same(A.outerIndexPtr(), B.outerIndexPtr(), A.cols() + 1) &&
         same(A.innerIndexPtr(), B.innerIndexPtr(), A.nonZeros()) &&
         same(A.valuePtr(), B.valuePtr(), A.nonZeros());
}

}  // namespace

ConstrainedSolver::ConstrainedSolver() = default;
ConstrainedSolver::~ConstrainedSolver() = default;

void ConstrainedSolver::set(const SparseMatrix& H, const SparseMatrix& J) {
  H_ = H;
  if (!same_matrix(J, J_)) {
    J_ = J;
    transposed_ = J.transpose();
    squares_ = transposed_ * J_;
  }
  const SparseMatrix other = H.transpose();
  const double size = std::max(largest_entry(H), 1e-300);
  is_symmetric_ = largest_entry(SparseMatrix(H - other)) <= not_symmetric * size;
  weight_ = penalty * size;
  shift_ = softness / size;
  SparseMatrix A = 0.5 * (H + other);
  if (J.rows() > 0) A += weight_ * squares_;
  symmetric_.factor(A);
  all_.reset();
}

bool ConstrainedSolver::ok() const { return symmetric_.ok(); }
bool ConstrainedSolver::definite() const { return symmetric_.ok() && symmetric_.negative() == 0; }
int ConstrainedSolver::negative() const { return symmetric_.negative(); }

VectorXd ConstrainedSolver::close(const VectorXd& g) const {
  return symmetric_.solve(weight_ * (transposed_ * g));
}

/// [H Jᵀ; J −s].
void ConstrainedSolver::factor_all() {
  const auto n = static_cast<int>(H_.cols()), m = static_cast<int>(J_.rows());
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](const SparseMatrix& A, int row, int column, double by) {
    for (int k = 0; k < A.outerSize(); ++k)
      for (SparseMatrix::InnerIterator e(A, k); e; ++e)
        if (e.value() != 0)
          entries.emplace_back(row + static_cast<int>(e.row()), column + static_cast<int>(e.col()),
                               by * e.value());
  };
  // With multipliers in units of forces.
  const double unit = weight_ / penalty;
  add(H_, 0, 0, 1);
  add(J_, n, 0, unit);
  add(transposed_, 0, n, unit);
  for (int k = 0; k < m; ++k) entries.emplace_back(n + k, n + k, -shift_ * unit * unit);
  SparseMatrix A(n + m, n + m);
  A.setFromTriplets(entries.begin(), entries.end());
  all_ = std::make_unique<SparseLu>();
  all_->factor(A);
}

bool ConstrainedSolver::iterate(const VectorXd& f, const VectorXd& g, VectorXd& x, VectorXd& mu, bool by_lu,
                                double& left) {
  constexpr int most_rounds = 40;
  const Eigen::Index n = f.size(), m = g.size();
  const double unit = weight_ / penalty;
  VectorXd force = f, violation = g;
  x = VectorXd::Zero(n);
  mu = VectorXd::Zero(m);
  const double size = std::max(f.norm(), m > 0 ? unit * g.norm() : 0.0);
  left = 1;
  if (size == 0) return true;
  for (int round = 0; round < most_rounds; ++round) {
    VectorXd dx, dmu(m);
    if (by_lu) {
      VectorXd right(n + m);
      right << force, unit * violation;
      const VectorXd found = all_->solve(right);
      dx = found.head(n);
      dmu = unit * found.tail(m);
    } else {
      VectorXd right = force;
      if (m > 0) right += weight_ * (transposed_ * violation);
      dx = symmetric_.solve(right);
      if (m > 0) dmu = weight_ * (J_ * dx - violation);
    }
    if (!dx.allFinite() || !dmu.allFinite()) return false;
    x += dx;
    mu += dmu;
    force = f - H_ * x;
    if (m > 0) {
      force -= transposed_ * mu;
      violation = g - J_ * x;
    }
    const double now = (force.norm() + (m > 0 ? unit * violation.norm() : 0.0)) / size;
    if (now <= solved) {
      left = now;
      return true;
    }
    if (round > 1 && now > 0.7 * left) {
      left = std::min(left, now);
      break;
    }
    left = now;
  }
  return left <= roughly;
}

bool ConstrainedSolver::solve(const VectorXd& f, const VectorXd& g, VectorXd& x, VectorXd& mu) {
  double left = 1;
  bool done = !all_ && iterate(f, g, x, mu, false, left);
  if (done && (is_symmetric_ || left < 1e-10)) return true;
  if (!all_) factor_all();
  if (!all_->ok()) return done;
  VectorXd other, other_mu;
  double other_left = 1;
  if (iterate(f, g, other, other_mu, true, other_left) && (!done || other_left < left)) {
    x = other;
    mu = other_mu;
    done = true;
  }
  return done;
}

}  // namespace mimbre::linalg
