#pragma once
#include <Eigen/Core>

#include "integrate/stepper.h"

namespace mimbre {

/// Solves M a + Φzᵀ λ = Q with Φ̈ = 0 for the accelerations, by corrections with M + κ Φzᵀ α Φz. Allocates
/// only when made.
class Accelerations {
 public:
  Accelerations(System& system, double tolerance);
  /// `multipliers`: λ, where it starts from what is there. Factorises the inertia at q. False: `status` tells
  /// what went wrong where; it counts iterations and factorisations, too.
  bool find(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& v, Eigen::VectorXd& a,
            Eigen::VectorXd& multipliers, StepStatus& status);
  /// The motion d that takes a violation of Φ or Φ̇ back, the least in the sense of the inertia as it is
  /// factorised.
  void take_back(const double* violation, Eigen::VectorXd& d);

 private:
  System& system_;
  double tolerance_;  ///< of the last correction, by the accelerations at play
  bool iterates_;
  Eigen::VectorXd r_, g_;
};

}  // namespace mimbre
