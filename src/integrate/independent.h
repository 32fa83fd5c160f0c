#pragma once
#include "integrate/anderson.h"
#include "integrate/dense.h"
#include "integrate/step_motion.h"

namespace mimbre {

/// Independent coordinates by a second velocity transformation, ż = R żi + (…), so that
///   Rᵀ (M z̈ − Q) = 0
/// (Serna, Avilés, García de Jalón 1982; coordinate partitioning of Wehage, Haug 1982). The rule of
/// integration holds in the independent coordinates; dependent positions, velocities and accelerations follow
/// from Φ = 0, Φ̇ = 0 and Φ̈ = 0, which hold to round-off. The set of coordinates is chosen anew at each
/// step's start, so that it is never badly conditioned; all coordinates are in the state, so that a change
/// needs no restart. At and through singular positions steps fail.
class IndependentStepper final : public Stepper {
 public:
  IndependentStepper(System& system, const IntegratorOptions& options);
  StepStatus step(State& state) override;
  void begun(State& s) const override { motion_.begun(s); }
  void set_step(double step) override;
  void transfer(StateTransfer& transfer) override { dense_.partition().transfer(transfer); }

 private:
  StepCode evaluate(const State& s, StepStatus& status);

  System& system_;
  StepMotion motion_;
  DenseSystem dense_;
  MatrixWeights weights_;
  Anderson mixing_;
  Eigen::VectorXd none_, r_, delta_, change_, violation_, multipliers_;
  Eigen::VectorXd predicted_;  ///< Φ before velocities follow the constraints
};

}  // namespace mimbre
