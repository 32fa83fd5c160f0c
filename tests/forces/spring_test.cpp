#include "forces/measure.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mimbre/model_file.h"
#include "mimbre/simulation.h"

namespace mimbre::spring_test {
namespace {

/// A slider on a vertical guide, 2 kg, held by a spring of 800 N/m whose ends meet at the start: ω = 20
/// rad/s.
constexpr const char* slider = R"(
mimbre: 1
bodies:
  mass: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}
joints:
  guide: {type: prismatic, between: [ground, mass], at: [0, 0, 0], axis: [0, 0, 1]}
springs:
  spring: {between: [ground, mass], at: [[0, 0, 0.1], [0, 0, 0]], elastic: "800*x"}
simulation: {step: 0.001, end: 1}
outputs:
  - {name: z, joint: guide}
)";

// Pulled through its anchor the mass goes on as if nothing were there.
TEST(Spring, WithoutLengthIsLinearThroughItsAnchor) {
  const auto model = Model::compile(parse_model(slider, "slider.yaml", "."));
  for (const auto formulation :
       {spec::Simulation::Formulation::relative, spec::Simulation::Formulation::natural}) {
    RunOptions options;
    options.formulation = formulation;
    Simulation simulation(model, options);
    ResultsRow row;
    for (int k = 0; k < 200; ++k) {
      ASSERT_TRUE(simulation.step().ok());
      simulation.sample(row);
      const double t = simulation.time(), omega = 20;
      EXPECT_NEAR(row.channels[0], (0.1 - 9.81 / (omega * omega)) * (1 - std::cos(omega * t)), 1e-4) << t;
    }
  }
}

TEST(Spring, PullsTheWayItsEndsPartWhereTheyMeet) {
  ElementData element;
  element.measure = Measure::distance;
  std::vector<double> storage(static_cast<std::size_t>(element_storage(element)), 0.0);
  ElementState<double> state = element_state(element, storage.data());
  Motion<double> a, b;
  a.position = b.position = a.velocity = Vec3d::Zero();
  b.velocity = Vec3d(0, 0, -2);
  measure_distance(a, b, state);
  EXPECT_EQ(state.x[0], 0);
  EXPECT_EQ(state.linear_of(0), Vec3d(0, 0, -1));
  EXPECT_EQ(state.v[0], 2);
  b.velocity.setZero();
  measure_distance(a, b, state);
  EXPECT_EQ(state.linear_of(0), Vec3d::Zero());
  EXPECT_EQ(state.v[0], 0);
}

}  // namespace
}  // namespace mimbre::spring_test
