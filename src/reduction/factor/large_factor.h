#pragma once
#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <string>

namespace mimbre::fe {

enum class Definiteness {
  definite,  ///< positive; else it is an error
  any        ///< where it is not positive definite, factors L D Lᵀ: slower
};

/// Sparse factorisation of a large symmetric matrix (lower triangle), Cholesky's where it is positive
/// definite. MIMBRE_SPARSE_SOLVER of the build selects which of large_factor_*.cpp is this class.
class LargeFactor {
 public:
  /// Throws std::invalid_argument with `what` when there are no factors.
  LargeFactor(const Eigen::SparseMatrix<double>& lower, const std::string& what,
              Definiteness matrix = Definiteness::definite);
  ~LargeFactor();
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace mimbre::fe
