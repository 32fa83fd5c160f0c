#pragma once
#include "integrate/anderson.h"
#include "integrate/step_motion.h"

namespace mimbre {

/// The index-3 augmented Lagrangian with Newmark or generalised-α in positions, then projections of
/// velocities and accelerations with the same factorised matrix (Lugrís 2008, 2.165–2.183). Quaternion
/// coordinates are integrated as a Lie group (Brüls, Cardona, Arnold 2012): the increment of a step is a
/// rotation vector. Allocates nothing in a step.
class IndexThree final : public Stepper {
 public:
  IndexThree(System& system, const IntegratorOptions& options);
  /// The system's last evaluation is then of the new positions and velocities (accelerations before their
  /// projection).
  StepStatus step(State& state) override;
  void begun(State& s) const override { motion_.begun(s); }
  /// Near singular positions, which only constraints have, a step is made again.
  int most_attempts() const override { return options_.fixed_cost || system_.equations() == 0 ? 1 : 2; }
  void set_step(double step) override;

 private:
  /// One step, or one near a singular position; on return whether it was near one.
  StepStatus attempt(State& state, bool precise, bool& near_singular);
  void project(double* target, const double* violation, double tolerance);

  System& system_;
  const Scales& scales_;
  StepMotion motion_;
  MatrixWeights weights_;
  Anderson mixing_;
  Eigen::VectorXd lambda_, r_, unprojected_;
  /// Of a fixed cost: the iterate from which the least correction was measured.
  struct {
    double off = 0;
    Eigen::VectorXd x, lambda;
  } nearest_;
  Eigen::VectorXd before_;                       ///< multipliers before an iteration
  Eigen::VectorXd g_, impulse_, force_, rates_;  // violation that is left; multipliers; rates foreseen
};

}  // namespace mimbre
