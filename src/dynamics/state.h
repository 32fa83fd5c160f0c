#pragma once
#include <Eigen/Core>

namespace mimbre {

/// The motion, and what the integrator remembers of it: copying it and stepping gives the same bits where the
/// system's tangent marks and the stepper's memory (Stepper::transfer) are the same, too.
struct State {
  double time = 0;
  Eigen::VectorXd q;            ///< positions
  Eigen::VectorXd v;            ///< velocities
  Eigen::VectorXd a;            ///< accelerations
  Eigen::VectorXd algorithmic;  ///< generalised-α's algorithmic accelerations; Newmark: equal to a
  Eigen::VectorXd multipliers;  ///< λ, N or N m
  Eigen::VectorXd z;            ///< internal states of force elements
  Eigen::VectorXd u;            ///< inputs, sampled signals, integrals of signals (SignalsData)
  double energy_error = 0;      ///< J, fed in so far, that the integrator `conserve` has still to take back
  bool started = false;  ///< the first step replaces a and algorithmic by what a step of its length sees
};

}  // namespace mimbre
