#pragma once
#include <Eigen/Core>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "mimbre/model.h"
#include "mimbre/simulation.h"

/// Mechanisms whose motion is smooth, and runs of them by integrators of high order.
namespace mimbre::test {

/// In how many steps the coarsest run of each rule covers `end`, s.
struct SmoothMechanism {
  const char* name;
  std::string text;
  double end;
  int steps_of_rk4, steps_of_dopri853, steps_of_radau;
};
void PrintTo(const SmoothMechanism& mechanism, std::ostream* out);

const std::vector<SmoothMechanism>& smooth_mechanisms();

/// Steps in one part each; with an accuracy as it asks.
RunOptions options_of(spec::Simulation::Integrator rule, double step, double accuracy = 0);

/// Positions and velocities at the end, one below the other.
Eigen::VectorXd run_with(const std::shared_ptr<const Model>& model, const RunOptions& options, double end);

}  // namespace mimbre::test
