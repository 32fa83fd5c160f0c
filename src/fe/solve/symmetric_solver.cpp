#include "fe/solve/symmetric_solver.h"

#include <Eigen/SparseCholesky>

namespace mimbre::fe {

Eigen::MatrixXd symmetric_times(const Eigen::SparseMatrix<double>& lower, const Eigen::MatrixXd& x) {
  return lower.selfadjointView<Eigen::Lower>() * x;
}

struct SymmetricSolver::Implementation {
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor;
  explicit Implementation(const Eigen::SparseMatrix<double>& matrix) : factor(matrix) {}
};

SymmetricSolver::SymmetricSolver(const Eigen::SparseMatrix<double>& matrix)
    : implementation_(std::make_unique<Implementation>(matrix)) {}
SymmetricSolver::~SymmetricSolver() = default;
SymmetricSolver::SymmetricSolver(SymmetricSolver&&) noexcept = default;
bool SymmetricSolver::ok() const { return implementation_->factor.info() == Eigen::Success; }
Eigen::MatrixXd SymmetricSolver::solve(const Eigen::MatrixXd& b) const {
  return implementation_->factor.solve(b);
}

}  // namespace mimbre::fe
