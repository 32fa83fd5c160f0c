#include "linalg/once/sparse_qr.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseQR>
#include <algorithm>
#include <limits>

namespace mimbre::linalg {

using Eigen::Index;
using Eigen::VectorXd;

struct SparseQr::Impl {
  Eigen::SparseQR<SparseMatrix, Eigen::COLAMDOrdering<int>> qr;
  SparseMatrix R;  ///< of the independent columns
  Index rows = 0;
};

SparseQr::SparseQr(const SparseMatrix& A, double threshold) : impl_(std::make_unique<Impl>()) {
  // A row of zeros below changes nothing, and makes sure that there are at least as many rows as columns.
  impl_->rows = A.rows();
  SparseMatrix tall = A;
  tall.conservativeResize(std::max(A.rows(), A.cols()), A.cols());
  tall.makeCompressed();
  impl_->qr.setPivotThreshold(threshold);
  impl_->qr.compute(tall);
  impl_->R = SparseMatrix(impl_->qr.matrixR()).topLeftCorner(rank(), rank());
}

SparseQr::~SparseQr() = default;

int SparseQr::rank() const { return static_cast<int>(impl_->qr.rank()); }

double SparseQr::least_pivot() const {
  return rank() > 0 ? VectorXd(impl_->R.diagonal()).cwiseAbs().minCoeff()
                    : std::numeric_limits<double>::infinity();
}

std::vector<int> SparseQr::dependent() const {
  const auto& order = impl_->qr.colsPermutation().indices();
  return {order.data() + rank(), order.data() + order.size()};
}

VectorXd SparseQr::null_vector(const VectorXd& of_dependent) const {
  const auto& order = impl_->qr.colsPermutation().indices();
  const Index r = rank(), n = order.size();
  VectorXd x = VectorXd::Zero(n);
  const SparseMatrix R = impl_->qr.matrixR();
  VectorXd ordered = -(R.topRightCorner(r, n - r) * of_dependent);
  impl_->R.triangularView<Eigen::Upper>().solveInPlace(ordered);
  for (Index k = 0; k < n; ++k) x[order[k]] = k < r ? ordered[k] : of_dependent[k - r];
  return x;
}

VectorXd SparseQr::shortest(const VectorXd& b) const {
  const auto& order = impl_->qr.colsPermutation().indices();
  VectorXd y = VectorXd::Zero(impl_->qr.rows()), independent(rank());
  for (Index k = 0; k < rank(); ++k) independent[k] = b[order[k]];
  impl_->R.transpose().triangularView<Eigen::Lower>().solveInPlace(independent);
  y.head(rank()) = independent;
  const VectorXd x = impl_->qr.matrixQ() * y;
  return x.head(impl_->rows);
}

}  // namespace mimbre::linalg
