#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mimbre/simulation.h"
#include "support/models.h"

/// Drives that are given by their speed: their position is its integral, from the joint's initial position.
namespace mimbre::test::speed_drive_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using Formulation = spec::Simulation::Formulation;

RunOptions options_of(Formulation formulation) {
  RunOptions options;
  options.formulation = formulation;
  options.step = 0.005;
  options.tolerance = 1e-9;
  return options;
}

/// A crank with this drive, a coupler and a slider, in the plane z–x; gravity acts.
std::shared_ptr<const Model> slider_crank(const std::string& drive) {
  return model_of(fmt::format(R"(
bodies:
  crank: {{mass: 1, com: [0.1, 0, 0], inertia: [0.01, 0.01, 0.01]}}
  rod: {{mass: 2, com: [0.5, 0, 0], inertia: [0.1, 0.1, 0.1]}}
  slider: {{mass: 3, com: [0.8, 0, 0], inertia: [0.1, 0.1, 0.1]}}
joints:
  main: {{type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 1, 0], {}}}
  pin: {{type: revolute, between: [crank, rod], at: [0.2, 0, 0], axis: [0, 1, 0]}}
  wrist: {{type: revolute, between: [rod, slider], at: [0.8, 0, 0], axis: [0, 1, 0]}}
  guide: {{type: prismatic, between: [ground, slider], at: [0.8, 0, 0], axis: [1, 0, 0]}}
outputs:
  - {{name: angle, joint: main}}
  - {{name: rate, joint_velocity: main}}
  - {{name: x, position: slider, component: x}}
  - {{name: force, joint_force: wrist, component: fx}}
simulation: {{step: 0.005, end: 0.5}}
)",
                              drive));
}

class SpeedDrive : public testing::TestWithParam<Formulation> {};

/// ∫ 0.3 + 12 t + 4 cos 20 t, given by hand, is the same drive.
TEST_P(SpeedDrive, IsTheIntegralAsAPosition) {
  Simulation speed(slider_crank("position: 0.3, drive: {speed: \"12*t + 4*cos(20*t)\"}"),
                   options_of(GetParam())),
      position(slider_crank("drive: {position: \"0.3 + 6*t^2 + 0.2*sin(20*t)\"}"), options_of(GetParam()));
  ResultsRow a, b;
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(speed.step().ok());
    ASSERT_TRUE(position.step().ok());
    speed.sample(a);
    position.sample(b);
    const double t = speed.time();
    EXPECT_NEAR(a.channels[0], 0.3 + 6 * t * t + 0.2 * std::sin(20 * t), 1e-7);
    EXPECT_NEAR(a.channels[1], 12 * t + 4 * std::cos(20 * t), 1e-5);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(a.channels[c], b.channels[c], 1e-7 * (1 + std::abs(b.channels[c])));
    EXPECT_NEAR(a.channels[3], b.channels[3], 1e-4 * (1 + std::abs(b.channels[3])));
  }
}

/// A speed with kinks is a drive without: a run-up from rest to 2 rad/s.
TEST_P(SpeedDrive, OfATableRunsUp) {
  const auto model = slider_crank("drive: {speed: {table: [[0, 0], [0.2, 2], [1, 2]]}}");
  Simulation s(model, options_of(GetParam()));
  EXPECT_THAT(s.warnings(), IsEmpty());
  for (int k = 0; k < 80; ++k) ASSERT_TRUE(s.step().ok());
  ResultsRow row;
  s.sample(row);
  EXPECT_NEAR(row.channels[0], 0.2 + 2 * 0.2, 1e-7);
  EXPECT_NEAR(row.channels[1], 2, 1e-6);
}

TEST_P(SpeedDrive, ThatJumpsIsWarnedOf) {
  Simulation s(slider_crank("drive: {speed: \"t < 0.25 ? 1 : 2\"}"), options_of(GetParam()));
  EXPECT_THAT(s.warnings(), ElementsAre(HasSubstr("changes its speed at once by 1 at t = 0.25 s")));
}

INSTANTIATE_TEST_SUITE_P(Of, SpeedDrive, testing::Values(Formulation::relative, Formulation::natural),
                         [](const auto& of) {
                           return of.param == Formulation::natural ? "natural" : "relative";
                         });

}  // namespace
}  // namespace mimbre::test::speed_drive_test
