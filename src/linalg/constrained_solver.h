#pragma once
#include <Eigen/SparseCore>
#include <memory>

#include "linalg/once/sparse_factor.h"

namespace mimbre::linalg {

/// Linear equations with constraints, for analyses: H x + Jᵀ μ = f, J x = g, H and J sparse. Rows of J should
/// have lengths near one; they may be redundant: μ is then one of several.
///
/// Where H is symmetric the factors are those of H + w JᵀJ, w large, and the multipliers follow by Hestenes'
/// and Powell's iteration (Fortin, Glowinski 1983), which also removes the round-off that w causes. Other
/// matrices are factorised with the constraints as they stand, L U.
class ConstrainedSolver {
 public:
  ConstrainedSolver();
  ~ConstrainedSolver();

  /// Factorises the symmetric part of H; L U follows where solve() needs it.
  void set(const SparseMatrix& H, const SparseMatrix& J);
  /// There are factors of the symmetric part.
  bool ok() const;
  /// The symmetric part of H is positive definite along the motions with J x = 0.
  bool definite() const;
  /// Number of motions with J x = 0 along which it is negative.
  int negative() const;
  /// False where the equations cannot be solved beyond a rough share, 1e-4 of f.
  bool solve(const Eigen::VectorXd& f, const Eigen::VectorXd& g, Eigen::VectorXd& x, Eigen::VectorXd& mu);
  /// The smallest x by H with nearly J x = g.
  Eigen::VectorXd close(const Eigen::VectorXd& g) const;

 private:
  bool iterate(const Eigen::VectorXd& f, const Eigen::VectorXd& g, Eigen::VectorXd& x, Eigen::VectorXd& mu,
               bool by_lu, double& left);
  void factor_all();

  SparseMatrix H_, J_, transposed_, squares_;
  SparseLdlt symmetric_;
  std::unique_ptr<SparseLu> all_;
  double weight_ = 0, shift_ = 0;
  bool is_symmetric_ = true;
};

}  // namespace mimbre::linalg
