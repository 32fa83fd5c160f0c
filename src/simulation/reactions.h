#pragma once
#include "integrate/stepper.h"

namespace mimbre {

/// Multipliers of the constraints in a state whose accelerations are known, as find_multipliers() finds them,
/// but in memory of its own and with the system's sparse factorisation: cheap enough for now and then during
/// a run.
class Reactions {
 public:
  explicit Reactions(const System& system);
  /// Neither allocates nor throws. Changes the system's factorisation; its last residual is that of `state`
  /// with the multipliers found, and false is returned, with multipliers of zero, where the matrix is
  /// singular.
  bool find(System& system, State& state);

 private:
  Eigen::VectorXd residual_, change_, jacobian_change_;
};

}  // namespace mimbre
