#include "support/simulate.h"

#include <gtest/gtest.h>

#include <limits>

#include "support/models.h"

namespace mimbre::test {

Simulation simulation_of(const std::shared_ptr<const Model>& model, Formulation formulation, double step) {
  RunOptions options;
  options.formulation = formulation;
  if (step > 0) options.step = step;
  return Simulation(model, options);
}

Simulation simulation_of(const std::string& text, Formulation formulation, double step) {
  return simulation_of(model_of(text), formulation, step);
}

Simulation precise_simulation_of(const std::string& text, Formulation formulation, double step) {
  RunOptions o;
  o.formulation = formulation;
  o.step = step;
  o.tolerance = 1e-9;
  o.rho = 0.9;
  return Simulation(model_of(text), o);
}

void run_to(Simulation& simulation, double end) {
  while (simulation.time() < end - 1e-9) {
    const StepReport report = simulation.step();
    ASSERT_TRUE(report.ok()) << simulation.explain(report);
  }
}

double channel(Simulation& simulation, const std::string& name) {
  ResultsRow row;
  simulation.sample(row);
  for (std::size_t k = 0; k < simulation.channels().size(); ++k)
    if (simulation.channels()[k].name == name) return row.channels[static_cast<Eigen::Index>(k)];
  ADD_FAILURE() << "no channel " << name;
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace mimbre::test
