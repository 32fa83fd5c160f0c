#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "dynamics/relative/system.h"
#include "integrate/index3.h"
#include "integrate/initial.h"
#include "mimbre/simulation.h"

/// Runs of the integrator itself, without what Simulation does around it.
namespace mimbre::test {

IntegratorOptions newmark(double step, double xi = 0);

IntegratorOptions generalised_alpha(double step, double rho);

State initial_state(const std::shared_ptr<const Model>& model);

struct Outcome {
  State state;
  int failed_step = -1;
  double position_violation = 0, velocity_violation = 0;  ///< largest of all steps
  int iterations = 0;
};

/// From `start` over `duration`; `watch` (optional) sees every accepted state, kinematics evaluated.
Outcome run(const std::shared_ptr<const Model>& model, const IntegratorOptions& options, double duration,
            State start, const std::function<void(relative::RelativeSystem&, const State&)>& watch = {});

Outcome run(const std::shared_ptr<const Model>& model, const IntegratorOptions& options, double duration);

/// log2 of the ratio of successive differences of x at steps h, h/2, h/4.
double order(const Eigen::VectorXd& coarse, const Eigen::VectorXd& middle, const Eigen::VectorXd& fine);

}  // namespace mimbre::test
