#pragma once
#include "integrate/anderson.h"
#include "integrate/step_motion.h"

namespace mimbre {

/// The equations of motion with σ = Φ̈ + 2ζω Φ̇ + ω² Φ instead of the constraints:
///   penalty            M z̈ + Φzᵀ α̂ σ = Q                                       (Lugrís 2008, 2.162)
///   index1_augmented   M z̈ + Φzᵀ (λ + α̂ σ) = Q, λ ← λ + α̂ σ until σ = 0        (2.163, 2.164)
/// implicit in positions, with the matrix of the index-3 formalism but for the penalty's weight. Redundant
/// equations do no harm. Allocates nothing in a step.
class PenaltyStepper final : public Stepper {
 public:
  PenaltyStepper(System& system, const IntegratorOptions& options, bool augmented);
  StepStatus step(State& state) override;
  void begun(State& s) const override { motion_.begun(s); }
  void set_step(double step) override;

 private:
  System& system_;
  StepMotion motion_;
  const bool augmented_;
  const double penalty_;   // κ
  double frequency_ = 0;   // ω
  double sigma_rate_ = 0;  // ∂σ/∂x = sigma_rate Φz
  MatrixWeights weights_;
  Anderson mixing_;
  Eigen::VectorXd lambda_, r_, sigma_, g_, change_;
};

}  // namespace mimbre
