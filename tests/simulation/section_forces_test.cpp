#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/models.h"
#include "support/simulate.h"

/// Section forces of bodies made of bars against beam theory, and against the reactions of joints.
namespace mimbre::test::section_forces_test {
namespace {

using ::testing::HasSubstr;
constexpr double diameter = 0.02, density = 7850, length = 1.5;
const double area = std::numbers::pi / 4 * diameter * diameter, weight = density * area * 9.81;

/// A round bar along x, its y axis along y; `more`: joints and the rest.
std::string bar(const std::string& flexible, const std::string& outputs, const std::string& more,
                double frame = 0) {
  return fmt::format(R"y(
materials: {{steel: {{young: 2.1e11, poisson: 0.3, density: {}}}}}
sections: {{rod: {{type: round, diameter: {}}}}}
bodies:
  beam:
    frame: {{at: [{}, 0, 0]}}
    flexible:
      material: steel
      section: rod
      nodes: {{root: [0, 0, 0], tip: [{}, 0, 0], middle: {{on: [span, 0.5]}}}}
      bars: {{span: {{from: root, to: tip, elements: 10, y: [0, 1, 0]}}}}
      {}
outputs:
{}
{}
)y",
                     density, diameter, frame, length, flexible, outputs, more);
}

/// All components at these places: "N 0.3", …
std::string sections_at(const std::vector<double>& places) {
  std::string text;
  for (const double x : places)
    for (const char* component : {"N", "Vy", "Vz", "T", "My", "Mz", "von_mises"})
      text += fmt::format("  - {{name: {} {}, section_force: beam, at: [{}, 0, 0], component: {}}}\n",
                          component, x, x, component);
  return text;
}

class SectionForcesOfBars : public testing::TestWithParam<Formulation> {};
INSTANTIATE_TEST_SUITE_P(BothFormulations, SectionForcesOfBars,
                         testing::Values(Formulation::relative, Formulation::natural));

TEST_P(SectionForcesOfBars, OfACantileverUnderItsWeight) {
  Simulation s =
      simulation_of(bar("clamped: [root]\n      dynamic_modes: 1", sections_at({0, 0.45, 0.9, 1.5}),
                        "initial: equilibrium\njoints: {wall: {type: fixed, between: [ground, beam.root]}}"),
                    GetParam(), 1e-3);
  for (const double x : {0.0, 0.45, 0.9, 1.5}) {
    const double rest = length - x, moment = 0.5 * weight * rest * rest,
                 stress = moment * (diameter / 2) / (std::numbers::pi / 64 * std::pow(diameter, 4));
    const auto at = [&](const char* component) { return channel(s, fmt::format("{} {}", component, x)); };
    EXPECT_NEAR(at("Vz"), -weight * rest, 1e-6 * weight) << x;
    EXPECT_NEAR(at("My"), moment, 1e-6 * weight) << x;
    EXPECT_NEAR(at("von_mises"), stress, 1e-3 * (stress + 1e3)) << x;
    for (const char* zero : {"N", "Vy", "T", "Mz"}) EXPECT_NEAR(at(zero), 0, 1e-6 * weight) << zero << x;
  }
}

/// N(x) = ½ ρ A ω² (L² − x²), though no mode stretches the bar.
TEST_P(SectionForcesOfBars, OfATurningBar) {
  const double speed = 40;
  Simulation s = simulation_of(
      bar("clamped: [root]\n      dynamic_modes: 4\n      stiffness_damping: 1e-3",
          sections_at({0, 0.75, 1.2}),
          fmt::format("gravity: [0, 0, 0]\njoints: {{hub: {{type: revolute, between: [ground, beam.root], "
                      "axis: [0, 0, 1], drive: {{speed: {}}}}}}}",
                      speed)),
      GetParam(), 1e-4);
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(s.step().ok());
  const double whole = 0.5 * density * area * speed * speed * length * length;
  for (const double x : {0.0, 0.75, 1.2}) {
    const double share = 1 - x * x / (length * length);
    EXPECT_NEAR(channel(s, fmt::format("N {}", x)), whole * share, 1e-5 * whole) << x;
    EXPECT_NEAR(channel(s, fmt::format("Vy {}", x)), 0, 1e-5 * whole) << x;
  }
}

/// A hub that speeds up evenly bends its bar as the inertia of the rest asks.
TEST_P(SectionForcesOfBars, OfABarThatIsSpedUp) {
  const double alpha = 3;
  Simulation s = simulation_of(
      bar("clamped: [root]\n      dynamic_modes: 3\n      stiffness_damping: 0.05", sections_at({0, 0.6}),
          fmt::format("gravity: [0, 0, 0]\njoints: {{hub: {{type: revolute, between: [ground, beam.root], "
                      "axis: [0, 0, 1], drive: {{position: \"{}*t^2\"}}}}}}",
                      alpha / 2)),
      GetParam(), 1e-3);
  while (s.time() < 1) ASSERT_TRUE(s.step().ok());
  const double q = density * area * alpha, L = length;
  for (const double x : {0.0, 0.6}) {
    EXPECT_NEAR(channel(s, fmt::format("Vy {}", x)), -0.5 * q * (L * L - x * x), 2e-3 * q) << x;
    EXPECT_NEAR(channel(s, fmt::format("Mz {}", x)), -q * (L * L * L / 3 - x * L * L / 2 + x * x * x / 6),
                2e-3 * q)
        << x;
  }
}

/// A bar on a hinge at one end and a spring under the other, loaded in the middle: M = F L/4 under the force,
/// wherever the body frame is held.
TEST_P(SectionForcesOfBars, OfASimplySupportedBar) {
  for (const char* held : {"root", "middle"}) {
    Simulation s = simulation_of(
        bar(fmt::format("clamped: [{}]\n      dynamic_modes: 3", held), sections_at({0.3, 0.75, 1.2}), R"y(
gravity: [0, 0, 0]
initial: equilibrium
joints:
  left: {type: revolute, between: [ground, beam.root], axis: [0, 1, 0]}
springs:
  right: {between: [ground, beam.tip], at: [[1.5, 0, 3], ~], elastic: {stiffness: 1e7, zero: 3}}
loads:
  push: {on: beam.middle, force: [0, 0, -50]}
)y",
            std::string(held) == "root" ? 0 : length / 2),
        GetParam(), 1e-3);
    const double force = 50;
    EXPECT_NEAR(channel(s, "My 0.3"), -0.5 * force * 0.3, 1e-4 * force) << held;
    EXPECT_NEAR(channel(s, "My 0.75"), -0.25 * force * length, 1e-4 * force) << held;
    EXPECT_NEAR(channel(s, "My 1.2"), -0.5 * force * 0.3, 1e-4 * force) << held;
    EXPECT_NEAR(channel(s, "Vz 0.3"), 0.5 * force * -1, 1e-4 * force) << held;
    EXPECT_NEAR(channel(s, "Vz 1.2"), 0.5 * force, 1e-4 * force) << held;
  }
}

/// At the root they are what the joint says, however the bar shakes.
TEST_P(SectionForcesOfBars, AtAJointAreItsReaction) {
  std::string outputs = sections_at({0});
  for (const char* component : {"fx", "fy", "fz", "mx", "my", "mz"})
    outputs += fmt::format("  - {{name: {}, joint_force: slide, component: {}}}\n", component, component);
  Simulation s = simulation_of(bar("clamped: [root]\n      dynamic_modes: 6", outputs, R"y(
joints:
  slide: {type: prismatic, between: [ground, beam.root], axis: [0, 0.6, 0.8], drive: {position: "0.002*sin(60*t)"}}
loads:
  push: {on: beam.tip, force: [3, 1, 0], moment: [0.2, 0, 0.1], scale: "sin(100*t)"}
)y"),
                               GetParam(), 2e-4);
  double most = 0;
  for (int k = 0; k < 500; ++k) {
    ASSERT_TRUE(s.step().ok());
    const char *const own[] = {"N 0", "Vy 0", "Vz 0", "T 0", "My 0", "Mz 0"}, *const joint[] = {"fx", "fy",
                                                                                                "fz", "mx",
                                                                                                "my", "mz"};
    for (std::size_t c = 0; c < 6; ++c) {
      const double reaction = channel(s, joint[c]);
      most = std::max(most, std::abs(reaction));
      ASSERT_NEAR(channel(s, own[c]), -reaction, 5e-3 * (1 + most)) << own[c] << " at " << s.time();
    }
  }
  EXPECT_GT(most, 5);
}

TEST(SectionForces, AreRefusedWhereThereAreNone) {
  const auto message = [](const std::string& text) {
    try {
      model_of(text);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(message(R"y(
bodies: {block: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {free: {type: floating, between: [ground, block], at: [0, 0, 0]}}
outputs: [{name: n, section_force: block, at: [0, 0, 0], component: N}]
)y"),
              HasSubstr("has no section forces"));
  EXPECT_THAT(message(bar("clamped: [root]\n      dynamic_modes: 2",
                          "  - {name: n, section_force: beam, at: [0, 0.5, 0], component: N}",
                          "joints: {wall: {type: fixed, between: [ground, beam.root]}}")),
              HasSubstr("0.5 m away from the nearest node"));
}

}  // namespace
}  // namespace mimbre::test::section_forces_test
