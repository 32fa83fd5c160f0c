#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "dynamics/system.h"
#include "linalg/block_sparse.h"
#include "linalg/complex.h"

namespace mimbre {

/// W(s) = M + s C + s² K + κ Φzᵀ α Φz of a system for s = h/γ and s = h/(α + iβ), the eigenvalues of Radau
/// IIA, factorised. The complex matrix has the pattern of the real one and is symmetric, not Hermitian, so
/// that the same elimination serves both. It is the sum of three assembled matrices, as the system's is
/// linear in its weights. A system without a pattern (long trees) has one dense block.
class RadauMatrices {
 public:
  RadauMatrices(System& system, double penalty);

  /// Of a step of h seconds, at the state of the system's last residual (q as given there). Jacobian products
  /// of the system then belong to it.
  linalg::FactorStatus factor(const double* q, double h);
  void solve(double* x) const { real_.solve(x); }
  void solve(linalg::Complex* x) const { complex_.solve(x); }

 private:
  void assemble(const double* q, const MatrixWeights& weights, std::vector<double>& values);

  System& system_;
  double penalty_;
  const bool dense_;
  linalg::BlockSymbolic one_block_;
  const linalg::BlockSymbolic& symbolic_;
  linalg::BlockFactor<double> real_;
  linalg::BlockFactor<linalg::Complex> complex_;
  std::vector<double> inertia_, damping_, stiffness_, copy_;
};

}  // namespace mimbre
