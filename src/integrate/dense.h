#pragma once
#include <Eigen/Core>

#include "integrate/partition.h"
#include "integrate/stepper.h"
#include "math/once/decompositions.h"

namespace mimbre {

/// Leading matrix f, Jacobian Φz and their reduction to independent coordinates, dense: for the formalisms
/// that eliminate the constraints instead of weighing them. f may be singular as long as the constraints hold
/// what it leaves free; equations may be redundant. Works on memory made once, so far as Eigen does.
class DenseSystem {
 public:
  explicit DenseSystem(System& system);

  /// f and Φz at the state of the system's last residual.
  void assemble(const double* q, const MatrixWeights& weights);
  /// Chooses the dependent coordinates: of each equation those that are easiest to move (the least entries in
  /// the diagonal of f), so that stiff ones, modes, stay independent. False at singular positions.
  bool choose(StepStatus& status);
  /// Factorises with the choice that was made. False where the equations or RᵀfR are singular.
  bool factor(StepStatus& status);
  /// δ and y of  f δ + Φzᵀ y = g,  Φz δ = b  (y = 0 for redundant equations).
  void solve(const double* g, const double* b, double* delta, double* y);
  /// The partition of the last factor().
  Partition& partition() { return partition_; }

 private:
  System& system_;
  Partition partition_;
  Eigen::MatrixXd f_, jacobian_, R_, fR_, reduced_;
  PivotedCholesky ldlt_;
  Eigen::VectorXd row_, row_weight_, column_weight_, order_, balance_, right_, unit_;
};

}  // namespace mimbre
