#pragma once
#include <Eigen/Core>

#include "dynamics/system.h"

namespace mimbre {

/// The coordinates of a system that all others drive and nothing depends on (System::driven_coordinates),
/// where a step changes the others without them.
class DrivenCoordinates {
 public:
  explicit DrivenCoordinates(System& system);

  bool any() const { return !system_.driven_coordinates().empty(); }

  /// Their part of the accelerations `a`: by the forces of the others, with the factorised matrix.
  void accelerate(double time, const double* q, const double* v, const double* multipliers, double* a);

  /// `target`, velocities or accelerations, has changed by `change`, which constraints did by `impulse`: adds
  /// what the driven ones do by that, M δ + Φzᵀ impulse = 0. Leaves the system evaluated elsewhere. `again`:
  /// the last call was at the same time and positions.
  void follow(double time, const double* q, const Eigen::VectorXd& change, const double* impulse,
              Eigen::VectorXd& target, bool again);

 private:
  /// Of what residuals have in them.
  void solve(const Eigen::VectorXd& r);

  System& system_;
  Eigen::VectorXd none_, change_, without_, r_, x_;
};

}  // namespace mimbre
