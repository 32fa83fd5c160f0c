#include "linalg/once/sparse_factor.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>
#include <algorithm>
#include <cmath>
#include <vector>

namespace mimbre::linalg {

using Eigen::MatrixXd;
using Eigen::VectorXd;

double largest_entry(const SparseMatrix& A) {
  double most = 0;
  for (Eigen::Index k = 0; k < A.nonZeros(); ++k) most = std::max(most, std::abs(A.valuePtr()[k]));
  return most;
}

struct SparseLdlt::Impl {
  Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower, Eigen::AMDOrdering<int>> solver;
  std::vector<int> starts, rows;
  bool ok = false;
  int negative = 0;
};

SparseLdlt::SparseLdlt() : impl_(std::make_unique<Impl>()) {}
SparseLdlt::~SparseLdlt() = default;

void SparseLdlt::factor(const SparseMatrix& A) {
  Impl& i = *impl_;
  const int *starts = A.outerIndexPtr(), *rows = A.innerIndexPtr();
  const auto same = [](const std::vector<int>& a, const int* b, Eigen::Index n) {
    return std::ssize(a) == n && std::equal(a.begin(), a.end(), b);
  };
  if (!same(i.starts, starts, A.cols() + 1) || !same(i.rows, rows, A.nonZeros())) {
    i.starts.assign(starts, starts + A.cols() + 1);
    i.rows.assign(rows, rows + A.nonZeros());
    i.solver.analyzePattern(A);
  }
  i.solver.factorize(A);
  i.ok = i.solver.info() == Eigen::Success;
  const VectorXd pivots = i.ok ? VectorXd(i.solver.vectorD()) : VectorXd();
  i.ok = i.ok && pivots.allFinite();
  i.negative = i.ok ? static_cast<int>((pivots.array() < 0).count()) : 0;
}

bool SparseLdlt::ok() const { return impl_->ok; }
int SparseLdlt::negative() const { return impl_->negative; }
VectorXd SparseLdlt::solve(const VectorXd& b) const { return impl_->solver.solve(b); }

struct SparseLu::Impl {
  Eigen::SparseLU<SparseMatrix, Eigen::COLAMDOrdering<int>> solver;
};

SparseLu::SparseLu() : impl_(std::make_unique<Impl>()) {}
SparseLu::~SparseLu() = default;

void SparseLu::factor(const SparseMatrix& A) {
  SparseMatrix compressed = A;
  compressed.makeCompressed();
  impl_->solver.compute(compressed);
}

bool SparseLu::ok() const { return impl_->solver.info() == Eigen::Success; }
MatrixXd SparseLu::solve(const MatrixXd& b) const { return impl_->solver.solve(b); }

}  // namespace mimbre::linalg
