#pragma once
#include <Eigen/Core>
#include <vector>

#include "integrate/explicit/accelerations.h"

namespace mimbre {

/// Explicit Runge–Kutta methods for mechanisms without stiff parts: rk4 of order 4, dopri853 of order 8. At
/// each stage accelerations follow from the equations of motion; after each step loops are closed by a
/// projection. Positions are the increment x from the start of the step, with ẋ = dexp⁻¹(x) v where they are
/// rotations (Munthe-Kaas 1998), so that the order holds for quaternions too. States of force elements and of
/// blocks follow, at each stage, from the start of the step.
///
/// A step that is too long for the fastest motion that it excites ends as `unstable`. dopri853 estimates its
/// error. Allocates only when made.
class ExplicitStepper final : public Stepper {
 public:
  ExplicitStepper(System& system, const IntegratorOptions& options);
  StepStatus step(State& state) override;
  void begun(State& s) const override;
  void set_step(double step) override { options_.step = step; }

 private:
  /// ẋ and v̇.
  struct Slope {
    Eigen::VectorXd rate, a;
  };
  template <class Method>
  bool make(const Method& method, const State& s, StepStatus& status);
  bool close(double t, StepStatus& status);
  double error_over_accuracy() const;
  template <class Method>
  double fastest(const Method& method, int& coordinate) const;

  System& system_;
  const bool eighth_;  ///< order, else fourth
  const double slow_;  ///< slow_motion()
  Accelerations accelerations_;
  std::vector<Slope> slopes_;                     ///< of the stages, and at the end of the step
  Eigen::VectorXd q_, v_, multipliers_;           ///< of a stage, then at the end
  Eigen::VectorXd x_;                             ///< increment from the start
  Eigen::VectorXd r_, zero_, first_multipliers_;  ///< scratch; zeros; at the start
};

}  // namespace mimbre
