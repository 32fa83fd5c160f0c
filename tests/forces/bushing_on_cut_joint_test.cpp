#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mimbre/simulation.h"
#include "mimbre/statics.h"
#include "support/models.h"

/// A bushing across a cut joint, which leaves it one angle, is a joint spring and damper there.
namespace mimbre::test::bushing_on_cut_joint_test {
namespace {

using Formulation = spec::Simulation::Formulation;

class BushingOnACutJoint : public testing::TestWithParam<Formulation> {};

constexpr const char* bushing = R"y(
bushings:
  hinge:
    between: [ground, rocker]
    at: [0.6, 0, 0]
    stiffness: [5e3, 6e3, 7e3, 200, 30, 300]
    damping: [10, 10, 10, 1, 0.3, 1]
)y";

std::string text(const char* on_joint, const std::string& elements) {
  return four_bar_text({{"rocker", fmt::format(", cut: always{}", on_joint)}}) + elements + R"y(
actuators:
  motor: {joint: crank, torque: 3}
outputs:
  - {name: x, position: coupler, component: x}
  - {name: z, position: coupler, component: z}
  - {name: rock, joint: rocker}
)y";
}

TEST_P(BushingOnACutJoint, MovesAsASpringOfTheJointDoes) {
  RunOptions options;
  options.formulation = GetParam();
  options.step = 0.001;
  Simulation by_bushing(model_of(text("", bushing)), options),
      by_spring(model_of(text(", spring: {stiffness: 30, damping: 0.3}", "")), options);
  ResultsRow found, expected;
  for (int k = 0; k < 800; ++k) {
    ASSERT_TRUE(by_bushing.step().ok());
    ASSERT_TRUE(by_spring.step().ok());
    by_bushing.sample(found);
    by_spring.sample(expected);
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(found.channels[c], expected.channels[c], 1e-8) << k;
  }
  EXPECT_GT(std::abs(found.channels[2]), 0.05);  // it has moved
  EXPECT_NEAR(by_bushing.energy().dissipated, by_spring.energy().dissipated, 1e-8);
  EXPECT_NEAR(by_bushing.energy().springs, by_spring.energy().springs, 1e-8);
}

TEST_P(BushingOnACutJoint, HoldsWhereASpringOfTheJointDoes) {
  const auto rests = [](const std::string& model) {
    RunOptions options;
    options.formulation = GetParam();
    Simulation simulation(model_of(model + "initial: equilibrium\n"), options);
    ResultsRow row;
    simulation.sample(row);
    return row;
  };
  const ResultsRow found = rests(text("", bushing)),
                   expected = rests(text(", spring: {stiffness: 30, damping: 0.3}", ""));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found.channels[c], expected.channels[c], 1e-8);
  EXPECT_GT(std::abs(found.channels[2]), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(BothFormulations, BushingOnACutJoint,
                         testing::Values(Formulation::relative, Formulation::natural));

}  // namespace
}  // namespace mimbre::test::bushing_on_cut_joint_test
