#include <Eigen/SparseCholesky>
#include <stdexcept>

#include "reduction/factor/large_factor.h"

namespace mimbre::fe {

using Eigen::MatrixXd;
using Eigen::SparseMatrix;

struct LargeFactor::Implementation {
  Eigen::SimplicialLLT<SparseMatrix<double>, Eigen::Lower> definite;
  std::unique_ptr<Eigen::SimplicialLDLT<SparseMatrix<double>, Eigen::Lower>> indefinite;
};

LargeFactor::LargeFactor(const SparseMatrix<double>& lower, const std::string& what, Definiteness matrix)
    : implementation_(std::make_unique<Implementation>()) {
  Implementation& own = *implementation_;
  if (own.definite.compute(lower).info() == Eigen::Success) return;
  if (matrix == Definiteness::definite) throw std::invalid_argument(what);
  own.indefinite = std::make_unique<Eigen::SimplicialLDLT<SparseMatrix<double>, Eigen::Lower>>(lower);
  if (own.indefinite->info() != Eigen::Success) throw std::invalid_argument(what);
}

LargeFactor::~LargeFactor() = default;

MatrixXd LargeFactor::solve(const MatrixXd& b) const {
  const Implementation& own = *implementation_;
  return own.indefinite ? MatrixXd(own.indefinite->solve(b)) : MatrixXd(own.definite.solve(b));
}

}  // namespace mimbre::fe
