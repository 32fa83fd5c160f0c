#include <gtest/gtest.h>

#include "mimbre/simulation.h"
#include "support/models.h"

/// Runs with inertia by projection give the trajectory of the shape integrals, to the mesh's accuracy.
namespace mimbre::test::projection_run_test {
namespace {

using Inertia = spec::Simulation::Inertia;

/// A swinging flexible arm that carries a disc.
std::string arm(int elements) {
  return R"(
materials: {soft: {young: 2e9, poisson: 0.3, density: 2000}}
sections: {thin: {type: round, diameter: 0.02}}
bodies:
  arm:
    frame: {at: [0, 0, 0]}
    flexible:
      material: soft
      section: thin
      nodes: {pivot: [0, 0, 0], tip: [0.6, 0.1, 0]}
      bars: {bar: {from: pivot, to: tip, elements: )" +
         std::to_string(elements) + R"(}}
      clamped: [pivot]
      static_modes: [{node: tip, all: true}]
  disc: {mass: 0.2, com: [0.7, 0.1, 0], inertia: [0.001, 0.001, 0.002]}
joints:
  pivot: {type: universal, between: [ground, arm], at: [0, 0, 0], axis: [0, 1, 0], axis2: [0, 0, 1]}
  tip: {type: revolute, between: [arm, disc], at: [0.6, 0.1, 0], axis: [0, 0, 1]}
)";
}

Eigen::VectorXd end_of_run(const std::shared_ptr<const Model>& model, Inertia inertia) {
  RunOptions options;
  options.step = 2e-3;
  options.inertia = inertia;
  Simulation simulation(model, options);
  for (int k = 0; k < 250; ++k) simulation.step();
  const Simulation::Snapshot s = simulation.save();
  return s.q;
}

TEST(ProjectionRun, FollowsTheIntegralsToTheMeshsAccuracy) {
  double previous = 0;
  for (const int elements : {5, 10}) {
    const auto model = model_of(arm(elements));
    const Eigen::VectorXd q = end_of_run(model, Inertia::integrals);
    const double difference =
        (end_of_run(model, Inertia::projection) - q).cwiseAbs().maxCoeff() / q.cwiseAbs().maxCoeff();
    EXPECT_LT((end_of_run(model, Inertia::projection_translations) - q).cwiseAbs().maxCoeff(),
              5e-4 * q.cwiseAbs().maxCoeff());  // no polar inertia of the section
    EXPECT_LT(difference, elements == 5 ? 2e-4 : previous / 3);
    previous = difference;
  }
}

}  // namespace
}  // namespace mimbre::test::projection_run_test
