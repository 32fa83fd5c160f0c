#include "fe/symmetric_solver.h"

#include "base/helper_threads.h"

#ifdef MIMBRE_WITH_CHOLMOD
#include <Eigen/CholmodSupport>
#else
#include <Eigen/SparseCholesky>
#endif

namespace mimbre::fe {

struct SymmetricSolver::Implementation {
#ifdef MIMBRE_WITH_CHOLMOD
  Eigen::CholmodDecomposition<Eigen::SparseMatrix<double>> factor;
#else
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor;
#endif
  explicit Implementation(const Eigen::SparseMatrix<double>& matrix) : factor(matrix) {}
};

SymmetricSolver::SymmetricSolver(const Eigen::SparseMatrix<double>& matrix) {
  const HelperThreads threads;
  implementation_ = std::make_unique<Implementation>(matrix);
}
SymmetricSolver::~SymmetricSolver() = default;
SymmetricSolver::SymmetricSolver(SymmetricSolver&&) noexcept = default;
bool SymmetricSolver::ok() const { return implementation_->factor.info() == Eigen::Success; }
Eigen::MatrixXd SymmetricSolver::solve(const Eigen::MatrixXd& b) const {
  const HelperThreads threads;
  return implementation_->factor.solve(b);
}

}  // namespace mimbre::fe
