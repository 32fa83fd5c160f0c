#pragma once
#include <Eigen/SparseCore>
#include <memory>

namespace mimbre::fe {

/// Sparse Cholesky factorisation of a symmetric finite-element matrix, of which the lower triangle is read.
/// CHOLMOD itself chooses between its simplicial and supernodal methods; frames of beams are so sparse that
/// it takes the simplicial one. For large models see LargeFactor.
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
