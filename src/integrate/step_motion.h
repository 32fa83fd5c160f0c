#pragma once
#include <Eigen/Core>
#include <optional>

#include "integrate/anderson.h"
#include "integrate/driven.h"
#include "integrate/rule.h"
#include "integrate/stepper.h"

namespace mimbre {

/// The motion over a step as a function of the increment x of its positions: what all formalisms share.
/// Quaternion coordinates are integrated as a Lie group (Brüls, Cardona, Arnold 2012): there x is a rotation
/// vector. Allocates only when made.
struct StepMotion {
  StepMotion(System& system, const IntegratorOptions& options);
  void set_step(double step);

  /// Takes over the accelerations at the start; the first step makes its own. Where these are not determined
  /// `status` names the coordinate that is the cause, and the step cannot be made.
  StepCode begin(const State& s, StepStatus& status);
  /// x for constant true accelerations, without what should not be extrapolated.
  void predict(const State& s);
  /// x for constant velocities.
  void predict_velocities(const State& s);
  /// q, v, a, algorithmic at the end of the step from x.
  void from_increment(const State& s);
  /// With what accelerations and multipliers a step that took its own began.
  void begun(State& s) const;
  /// The end of the step becomes the state.
  void accept(State& s, const Eigen::VectorXd& multipliers) const;

  System& system;
  RuleCoefficients rule;
  double h = 0;
  double rate = 0;                          ///< ∂ż/∂x = γ/(β h)
  double scale = 0;                         ///< s = β h² (1 − αf)/(1 − αm), so that ∂z̈/∂x = 1/s
  double penalty;                           ///< κ of the first step's accelerations
  Eigen::VectorXd x, q, v, a, algorithmic;  ///< at the end of the step
  Eigen::VectorXd start_a, start_algorithmic;  ///< at its start
  DrivenCoordinates driven;

 private:
  StepCode start(const State& s, StepStatus& status);
  StepCode break_away(const State& s, StepStatus& status);
  Eigen::VectorXd r_, g_, change_, start_multipliers_, stuck_multipliers_;
  std::optional<Anderson> mixing_;  ///< of the rounds of the start, where loads of inertia stiffen bodies
  Eigen::VectorXd along_;           ///< what it mixes along: multipliers, loads
};

}  // namespace mimbre
