#pragma once
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

namespace mimbre::linalg {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// A P = Q R of a sparse matrix, its columns put in an order of little fill; those that add no more than
/// `threshold` (a length) to the columns before them are set aside as dependent. It allocates.
class SparseQr {
 public:
  SparseQr(const SparseMatrix& A, double threshold);
  ~SparseQr();
  SparseQr(const SparseQr&) = delete;
  SparseQr& operator=(const SparseQr&) = delete;

  int rank() const;
  /// The least that a column adds which was not set aside: a larger threshold below it changes nothing.
  double least_pivot() const;
  /// Columns that were set aside.
  std::vector<int> dependent() const;
  /// x with A x = 0, but for the threshold, that has these values in the dependent columns.
  Eigen::VectorXd null_vector(const Eigen::VectorXd& of_dependent) const;
  /// Shortest x with xᵀ a = b for every column a that was not set aside and its entry of b.
  Eigen::VectorXd shortest(const Eigen::VectorXd& b) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace mimbre::linalg
