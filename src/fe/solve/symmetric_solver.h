#pragma once
#include <Eigen/SparseCore>
#include <memory>

namespace mimbre::fe {

/// The product with a symmetric matrix of which the lower triangle is given.
Eigen::MatrixXd symmetric_times(const Eigen::SparseMatrix<double>& lower, const Eigen::MatrixXd& x);

/// Sparse factorisation L D Lᵀ of a symmetric finite-element matrix, of which the lower triangle is read:
/// entry by entry, for frames of beams, which are so sparse that dense blocks gain nothing. For large models
/// see LargeFactor.
class SymmetricSolver {
 public:
  explicit SymmetricSolver(const Eigen::SparseMatrix<double>& matrix);
  ~SymmetricSolver();
  SymmetricSolver(SymmetricSolver&&) noexcept;
  bool ok() const;  ///< there are factors
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace mimbre::fe
