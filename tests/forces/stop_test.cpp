#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "math/restitution.h"
#include "support/models.h"
#include "support/simulate.h"

/// Stops at the ends of a travel: impacts, rest, depth.
namespace mimbre::stop_test {
namespace {

using namespace test;

std::string slider(const std::string& stop, double velocity, double gravity = 0) {
  return fmt::format(R"y(
gravity: [0, 0, {}]
bodies: {{mass: {{mass: 3, com: [0, 0, 0], inertia: [1, 1, 1]}}}}
joints: {{guide: {{type: prismatic, between: [ground, mass], at: [0, 0, 0], axis: [0, 0, 1], velocity: {}}}}}
stops: {{end: {{{}}}}}
outputs: [{{name: z, joint: guide}}, {{name: v, joint_velocity: guide}}]
simulation: {{step: 0.001, end: 1}}
)y",
                     gravity, velocity, stop);
}

class Stop : public testing::TestWithParam<Formulation> {};

/// Five speeds, two exponents, both ends: what comes back is the share that was asked for.
TEST_P(Stop, ThrowsBackTheShareThatIsAskedFor) {
  for (const double restitution : {0.05, 0.3, 0.7, 1.0})
    for (const double speed : {-0.05, -0.2, 1.0, -3.0, 10.0})
      for (const double exponent : {1.0, 1.5}) {
        const std::string text =
            slider(fmt::format("joint: guide, lower: -0.01, upper: 0.01, stiffness: 1e6, exponent: {}, "
                               "restitution: {}",
                               exponent, restitution),
                   speed);
        // An impact takes about π √(m/k); the step is a small part of it, and of the time to get there.
        Simulation simulation = simulation_of(text, GetParam(), 1e-5);
        double v = speed;
        while (v * speed > 0 || std::abs(channel(simulation, "z")) > 0.01) {
          ASSERT_TRUE(simulation.step().ok());
          v = channel(simulation, "v");
          ASSERT_LT(simulation.time(), 1) << restitution << " " << speed;
        }
        EXPECT_NEAR(-v / speed, restitution, 5e-3) << speed << " " << exponent;
        EXPECT_NEAR(simulation.energy().numerical, 0, 2e-3 * 1.5 * speed * speed);
      }
}

TEST_P(Stop, HoldsAWeightAtTheDepthOfItsForce) {
  Simulation linear = simulation_of(
      slider("joint: guide, lower: 0, stiffness: 1e5, restitution: 0.2", 0, -9.81), GetParam(), 1e-3);
  Simulation progressive = simulation_of(
      slider("joint: guide, lower: 0, stiffness: 1e5, exponent: 2, depth: 1e-3, restitution: 0.2", 0, -9.81),
      GetParam(), 1e-3);
  for (int k = 0; k < 3000; ++k) {
    ASSERT_TRUE(linear.step().ok());
    ASSERT_TRUE(progressive.step().ok());
  }
  const double weight = 3 * 9.81;
  EXPECT_NEAR(channel(linear, "z"), -weight / 1e5, 1e-8);
  // f = k e/2 (d/e)².
  EXPECT_NEAR(channel(progressive, "z"), -1e-3 * std::sqrt(2 * weight / (1e5 * 1e-3)), 1e-7);
  EXPECT_NEAR(channel(linear, "v"), 0, 1e-6);
}

/// A bump stop along the line of two points pushes them apart, and lets them go.
TEST_P(Stop, ActsAlongALineToo) {
  const std::string text = R"y(
bodies: {mass: {mass: 3, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {guide: {type: prismatic, between: [ground, mass], at: [0, 0, 0], axis: [0, 0, 1]}}
stops: {bump: {between: [ground, mass], at: [[0, 0, -0.5], [0, 0, 0]], lower: 0.4, stiffness: 2e4, restitution: 0.1}}
outputs: [{name: z, joint: guide}]
simulation: {step: 0.0005, end: 1}
)y";
  Simulation simulation = simulation_of(text, GetParam(), 5e-4);
  double lowest = 0;
  while (simulation.time() < 4) {
    ASSERT_TRUE(simulation.step().ok());
    lowest = std::min(lowest, channel(simulation, "z"));
  }
  EXPECT_NEAR(channel(simulation, "z"), -0.1 - 3 * 9.81 / 2e4, 1e-6);
  EXPECT_GT(lowest, -0.12);
  EXPECT_NEAR(simulation.energy().numerical, 0, 1e-2);
}

INSTANTIATE_TEST_SUITE_P(Both, Stop, testing::Values(Formulation::relative, Formulation::natural));

TEST(Restitution, SolvesItsEquation) {
  for (const double r : {0.05, 0.1, 0.3, 0.5, 0.9, 0.999}) {
    const double a = restitution_damping(r);
    EXPECT_NEAR(a * (1 + r), std::log((1 + a) / (1 - a * r)), 1e-6) << r;
    EXPECT_GT(a, 0);
  }
  EXPECT_EQ(restitution_damping(1), 0);
}

TEST(StopFile, WhatIsWrongIsTold) {
  const auto said = [](const std::string& stop) {
    try {
      model_of(slider(stop, 0));
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  EXPECT_NE(
      said("joint: guide, lower: 0, stiffness: 1e5, restitution: 1.5").find("is 1.5; it can be at most 1"),
      std::string::npos);
  EXPECT_NE(said("joint: guide, lower: 0").find("'stiffness' is missing"), std::string::npos);
  EXPECT_NE(said("joint: guide, lower: 1, upper: 0, stiffness: 10").find("lower"), std::string::npos);
  EXPECT_NE(said("joint: guide, stiffness: 10").find("'lower' or 'upper'"), std::string::npos);
}

}  // namespace
}  // namespace mimbre::stop_test
