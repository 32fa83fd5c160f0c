#pragma once
#include "integrate/anderson.h"
#include "integrate/dense.h"
#include "integrate/step_motion.h"

namespace mimbre {

/// Lagrange multipliers with the constraints differentiated twice,
///   M z̈ + Φzᵀ λ = Q,   Φ̈ = 0                        (Lugrís 2008, 2.158)
///   or  Φ̈ + 2ζω Φ̇ + ω² Φ = 0                         (2.160, Baumgarte 1972)
/// implicit in positions. The saddle-point matrix [f Φzᵀ; Φz 0] is factorised by elimination of Φz with
/// complete pivoting; redundant equations get no multiplier. At and through singular positions steps fail.
class LagrangeStepper final : public Stepper {
 public:
  LagrangeStepper(System& system, const IntegratorOptions& options, bool baumgarte);
  StepStatus step(State& state) override;
  void begun(State& s) const override { motion_.begun(s); }
  void set_step(double step) override;
  void transfer(StateTransfer& transfer) override { dense_.partition().transfer(transfer); }

 private:
  System& system_;
  StepMotion motion_;
  DenseSystem dense_;
  const bool stabilises_;
  double frequency_ = 0;   // ω
  double sigma_rate_ = 0;  // ∂σ/∂x = sigma_rate Φz
  MatrixWeights weights_;
  Anderson mixing_;
  Eigen::VectorXd lambda_, r_, sigma_, change_, delta_;
};

}  // namespace mimbre
