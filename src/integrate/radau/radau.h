#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "integrate/radau/radau_matrices.h"
#include "integrate/radau/radau_method.h"
#include "integrate/stepper.h"

namespace mimbre {

/// Radau IIA of order 5 (Hairer and Wanner 1996, IV.8), stiff mechanisms and loops included: it is L-stable.
/// Unknown at each of the three stages are accelerations and multipliers of  M a + Φzᵀ λ = Q, Φ̈ = 0  (index
/// 1), which have the full order then, as positions and velocities have; after each step these are projected
/// onto Φ = 0 and Φ̇ = 0. Positions are the increment x from the start of the step, with ẋ = dexp⁻¹(x) v where
/// they are rotations (Munthe-Kaas 1998). Simplified Newton iterations with the matrices of the start
/// (RadauMatrices), from the polynomial of the step before. Redundant equations do no harm: multipliers
/// follow by a penalty.
///
/// States of force elements and of blocks follow, at each stage, from the start of the step. Allocates only
/// when made.
class RadauStepper final : public Stepper {
 public:
  RadauStepper(System& system, const IntegratorOptions& options);
  StepStatus step(State& state) override;
  void begun(State& s) const override;
  void set_step(double step) override { options_.step = step; }
  int order_of_error() const override { return 4; }
  void transfer(StateTransfer& transfer) override;
  void forget() override { last_step_ = 0; }

 private:
  struct Stage {
    Eigen::VectorXd q, x, v, a, multipliers;
    Eigen::VectorXd r, g;          ///< residual and Φ̈, then their changes of a and of the multipliers
    Eigen::VectorXd rate, change;  ///< ẋ; of v, then of x
    Eigen::VectorXd last_a, last_multipliers;  ///< of the step before
  };

  void guess(const State& s);
  void follow(const State& s);
  bool evaluate(const State& s, StepStatus& status);
  void correct();
  double apply(const State& s);
  bool iterate(const State& s, StepStatus& status);
  void solve(Eigen::VectorXd& r, Eigen::VectorXd& g);
  double error_over_accuracy(const State& s);
  void close(double t);

  System& system_;
  const double slow_;  ///< slow_motion()
  const double penalty_, newton_tolerance_;
  RadauMatrices matrices_;
  std::array<Stage, radau::stages> stages_;
  double last_step_ = 0;  ///< s, whose accelerations are known; 0: none are
  bool begins_ = false;   ///< the last step took accelerations of its own
  std::vector<linalg::Complex> complex_;
  Eigen::VectorXd q_, v_, r_, g_, d_, zero_, by_x_, by_v_, error_x_, error_v_;
};

}  // namespace mimbre
