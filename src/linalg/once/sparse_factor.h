#pragma once
#include <Eigen/SparseCore>
#include <memory>

/// Factorisations of sparse matrices by scalars, for analyses. They allocate.
namespace mimbre::linalg {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// The largest of |Aᵢⱼ|; 0 of no entries.
double largest_entry(const SparseMatrix& A);

/// A = L D Lᵀ of a symmetric matrix of which the lower triangle is read, its unknowns in an order of little
/// fill, without exchanging pivots. The order is kept while the pattern is the same.
class SparseLdlt {
 public:
  SparseLdlt();
  ~SparseLdlt();
  void factor(const SparseMatrix& A);
  bool ok() const;       ///< no pivot vanished
  int negative() const;  ///< number of negative pivots: of negative eigenvalues
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A P = L U of any regular matrix, rows exchanged.
class SparseLu {
 public:
  SparseLu();
  ~SparseLu();
  void factor(const SparseMatrix& A);
  bool ok() const;
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace mimbre::linalg
