#pragma once
#include <Eigen/Core>

namespace mimbre {

/// What must be saved to go on: copying it and stepping gives the same bits.
struct State {
  double time = 0;
  Eigen::VectorXd q;            ///< positions
  Eigen::VectorXd v;            ///< velocities
  Eigen::VectorXd a;            ///< accelerations
  Eigen::VectorXd algorithmic;  ///< generalised-α's algorithmic accelerations; Newmark: equal to a
  Eigen::VectorXd multipliers;  ///< λ, N or N m
  double energy_error = 0;      ///< J, fed in so far, that the integrator `conserve` has still to take back
  bool started = false;  ///< the first step replaces a and algorithmic by what a step of its length sees
};

}  // namespace mimbre
