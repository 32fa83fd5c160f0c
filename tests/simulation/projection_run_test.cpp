#include <gtest/gtest.h>

#include <cmath>

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

/// Free, spinning and vibrating: a bent arm of two elements a bar with rotary inertia, and a disc on a soft
/// spring.
constexpr std::string_view spinning = R"(
gravity: [0, 0, 0]
materials: {soft: {young: 2e8, poisson: 0.3, density: 2000}}
sections: {thick: {type: rectangle, height: 0.06, width: 0.04}}
bodies:
  arm:
    frame: {at: [0, 0, 0]}
    flexible:
      material: soft
      section: thick
      beam_theory: rayleigh
      nodes: {root: [0, 0, 0], knee: [0.4, 0.1, 0], tip: [0.5, 0.4, 0.2]}
      bars:
        first: {from: root, to: knee, elements: 2, y: [0, 0, 1]}
        second: {from: knee, to: tip, elements: 2, y: [0, 0, 1]}
      clamped: [root]
      static_modes: [{node: tip, all: true}]
  disc: {mass: 0.3, com: [0.55, 0.45, 0.2], inertia: [0.001, 0.001, 0.002]}
joints:
  free:
    type: floating
    between: [ground, arm]
    at: [0, 0, 0]
    velocity: [3, -2, 1, 9, 6, -12]
  hinge: {type: spherical, between: [arm, disc], at: [0.5, 0.4, 0.2]}
springs: {pull: {between: [arm, disc], at: [[0, 0, 0], [0.55, 0.45, 0.2]], elastic: {stiffness: 50, zero: 0.5}}}
)";

/// The largest imbalance, J.
double imbalance(const std::shared_ptr<const Model>& model, Inertia inertia,
                 spec::Simulation::Formulation formulation, double step) {
  RunOptions options;
  options.step = step;
  options.inertia = inertia;
  options.formulation = formulation;
  options.integrator = spec::Simulation::Integrator::newmark;
  Simulation s(model, options);
  double most = 0;
  for (int k = 0; k < std::lround(0.05 / step); ++k) {
    s.step();
    most = std::max(most, std::abs(s.energy().numerical));
  }
  return most;
}

TEST(ProjectionRun, TheBalanceOfACoarseMeshClosesWithTheSquareOfTheStep) {
  const auto model = model_of(std::string(spinning));
  for (const auto formulation :
       {spec::Simulation::Formulation::relative, spec::Simulation::Formulation::natural}) {
    const double coarse = imbalance(model, Inertia::projection, formulation, 2e-4),
                 fine = imbalance(model, Inertia::projection, formulation, 1e-4),
                 finest = imbalance(model, Inertia::projection, formulation, 5e-5);
    EXPECT_NEAR(coarse / fine, 4, 0.3);
    EXPECT_NEAR(fine / finest, 4, 0.3);
    EXPECT_LT(finest, 2 * imbalance(model, Inertia::integrals, formulation, 5e-5));
  }
}

}  // namespace
}  // namespace mimbre::test::projection_run_test
