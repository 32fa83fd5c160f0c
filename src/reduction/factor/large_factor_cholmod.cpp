#include <Eigen/CholmodSupport>
#include <stdexcept>

#include "base/one_thread.h"
#include "reduction/factor/large_factor.h"

namespace mimbre::fe {

using Eigen::MatrixXd;
using Eigen::SparseMatrix;

namespace {

using Definite = Eigen::CholmodSupernodalLLT<SparseMatrix<double>, Eigen::Lower>;
using Indefinite = Eigen::CholmodSimplicialLDLT<SparseMatrix<double>, Eigen::Lower>;

template <typename Solver>
bool factorise(Solver& solver, const SparseMatrix<double>& lower) {
  // Nested dissection halves the factor of solids; the default would first try minimum degree.
  if (lower.rows() > 20000) {
    solver.cholmod().nmethods = 1;
    solver.cholmod().method[0].ordering = CHOLMOD_METIS;
    solver.cholmod().postorder = 1;
  }
  solver.cholmod().print = 0;
  solver.analyzePattern(lower);
  solver.factorize(lower);
  return solver.info() == Eigen::Success;
}

}  // namespace

struct LargeFactor::Implementation {
  mutable Definite definite;
  mutable std::unique_ptr<Indefinite> indefinite;
};

LargeFactor::LargeFactor(const SparseMatrix<double>& lower, const std::string& what, Definiteness matrix)
    : implementation_(std::make_unique<Implementation>()) {
  const OneThread alone;
  Implementation& own = *implementation_;
  if (factorise(own.definite, lower)) return;
  if (matrix == Definiteness::definite) throw std::invalid_argument(what);
  own.indefinite = std::make_unique<Indefinite>();
  if (!factorise(*own.indefinite, lower)) throw std::invalid_argument(what);
}

LargeFactor::~LargeFactor() = default;

MatrixXd LargeFactor::solve(const MatrixXd& b) const {
  const OneThread alone;
  const Implementation& own = *implementation_;
  return own.indefinite ? MatrixXd(own.indefinite->solve(b)) : MatrixXd(own.definite.solve(b));
}

}  // namespace mimbre::fe
