#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mimbre/simulation.h"
#include "support/models.h"

/// Outputs of angular velocity, centre of mass and momentum, against the laws that they obey.
namespace mimbre::test::momentum_outputs_test {
namespace {

using Eigen::Vector3d;
using Formulation = spec::Simulation::Formulation;

class MomentumOutputs : public testing::TestWithParam<Formulation> {
 protected:
  Simulation simulation(const std::string& text, double step) const {
    RunOptions options;
    options.formulation = GetParam();
    options.step = step;
    options.tolerance = 1e-9;
    return Simulation(model_of(text), options);
  }
};

/// Outputs `kind: of` named NAMEx … NAMEz.
std::string xyz(const std::string& name, const std::string& what) {
  std::string text;
  for (const char axis : {'x', 'y', 'z'})
    text += "  - {name: " + name + axis + ", " + what + ", component: " + axis + "}\n";
  return text;
}

Vector3d three(const ResultsRow& row, int first) { return row.channels.segment<3>(first); }

/// A symmetric top without forces: in its own axes the spin about its axis of symmetry stays and the other
/// part turns with (1 − J3/J1) ω3; the angular momentum is A J ω and stays.
TEST_P(MomentumOutputs, OfAFreeTop) {
  Simulation s =
      simulation(R"(
gravity: [0, 0, 0]
bodies:
  top: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1.5]}
joints:
  fly: {type: floating, between: [ground, top], at: [0, 0, 0], velocity: [3, 0, 1, 0.4, 0, 2]}
outputs:
)" + xyz("own", "angular_velocity: top, axes: own") +
                     xyz("w", "angular_velocity: top") + xyz("p", "linear_momentum: top") +
                     xyz("L", "angular_momentum: top") +
                     xyz("L0", "angular_momentum: top, about: [1, 2, 3]") + xyz("c", "centre_of_mass: top"),
                 0.002);
  ResultsRow row;
  for (int k = 0; k < 400; ++k) {
    ASSERT_TRUE(s.step().ok());
    s.sample(row);
    const double t = s.time(), turn = (1.5 - 1) * 2 * t;
    const Vector3d own = three(row, 0), p = three(row, 6), L = three(row, 9), centre = three(row, 15);
    EXPECT_NEAR(own[0], 0.4 * std::cos(turn), 1e-5);
    EXPECT_NEAR(own[1], 0.4 * std::sin(turn), 1e-5);
    EXPECT_NEAR(own[2], 2, 1e-6);
    EXPECT_NEAR(three(row, 3).norm(), own.norm(), 1e-12);
    EXPECT_LT((p - Vector3d(6, 0, 2)).norm(), 1e-7);
    EXPECT_LT((L - Vector3d(0.4, 0, 3)).norm(), 1e-5);
    EXPECT_LT((centre - t * Vector3d(3, 0, 1)).norm(), 1e-7);
    EXPECT_LT((three(row, 12) - L - (centre - Vector3d(1, 2, 3)).cross(p)).norm(), 1e-12);
  }
  EXPECT_EQ(s.channels()[0].unit, "rad/s");
  EXPECT_EQ(s.channels()[6].unit, "kg m/s");
  EXPECT_EQ(s.channels()[9].unit, "kg m²/s");
}

/// The same top. With Ω = (1 − J3/J1) ω3, in its own axes ω̇ = Ω e3 × ω; in global axes the angular velocity
/// goes around the angular momentum, ω̇ = L × ω / J1.
TEST_P(MomentumOutputs, AngularAccelerationOfAFreeTop) {
  Simulation s = simulation(R"(
gravity: [0, 0, 0]
bodies:
  top: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1.5]}
joints:
  fly: {type: floating, between: [ground, top], at: [0, 0, 0], velocity: [3, 0, 1, 0.4, 0, 2]}
outputs:
)" + xyz("own", "angular_acceleration: top, axes: own") +
                                xyz("a", "angular_acceleration: top") + xyz("w", "angular_velocity: top"),
                            0.002);
  ResultsRow row;
  for (int k = 0; k < 400; ++k) {
    ASSERT_TRUE(s.step().ok());
    s.sample(row);
    const double turn = (1.5 - 1) * 2 * s.time();
    const Vector3d L(0.4, 0, 3);
    EXPECT_LT((three(row, 0) - 0.4 * Vector3d(-std::sin(turn), std::cos(turn), 0)).norm(), 1e-5);
    EXPECT_LT((three(row, 3) - L.cross(three(row, 6))).norm(), 1e-5);
  }
  EXPECT_EQ(s.channels()[0].unit, "rad/s²");
  EXPECT_EQ(s.channels()[0].meaning, "angular acceleration of 'top' about x of its own axes");
}

const std::string beam = R"(
materials:
  rubber: {young: 2e6, poisson: 0.4, density: 1000}
sections:
  bar: {type: round, diameter: 0.05}
bodies:
  beam:
    frame: {at: [0, 0, 0], x: [1, 0, 0], y: [0, 1, 0]}
    flexible:
      material: rubber
      section: bar
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {bar: {from: root, to: tip, elements: 8}}
      clamped: [root]
      dynamic_modes: 4
      static_modes: [{node: tip, along: [0, 0, 1]}]
)";

/// Two bodies, one of them flexible, on a joint, thrown and falling: together they follow the parabola of
/// their mass, and turn about their centre of mass with the angular momentum of the start.
TEST_P(MomentumOutputs, OfAThrownPair) {
  Simulation s = simulation(beam + R"(
  ball: {mass: 3, com: [-0.2, 0, 0.1], inertia: [0.01, 0.02, 0.03]}
joints:
  fly: {type: floating, between: [ground, ball], at: [-0.2, 0, 0.1], velocity: [1, 2, 3, 0, 1, 0.5]}
  hinge: {type: revolute, between: [ball, beam], at: [0, 0, 0], axis: [0, 1, 0], velocity: -2}
outputs:
)" + xyz("p", "linear_momentum: all") +
                                xyz("L", "angular_momentum: [beam, ball]") + xyz("c", "centre_of_mass: all") +
                                xyz("a", "linear_momentum: ball") + xyz("b", "linear_momentum: [beam]") +
                                xyz("v", "velocity: ball"),
                            0.002);
  const double mass = 3 + 1000 * std::numbers::pi * 0.05 * 0.05 / 4;
  ResultsRow row;
  s.sample(row);
  const Vector3d p0 = three(row, 0), L0 = three(row, 3), c0 = three(row, 6);
  EXPECT_NEAR(c0[0], (3 * -0.2 + (mass - 3) * 0.5) / mass, 1e-9);
  double bent = 0;
  for (int k = 0; k < 200; ++k) {
    ASSERT_TRUE(s.step().ok());
    s.sample(row);
    const double t = s.time();
    const Vector3d fall(0, 0, -9.81 * t);
    EXPECT_LT((three(row, 0) - p0 - mass * fall).norm(), 1e-5);
    EXPECT_LT((three(row, 3) - L0).norm(), 1e-4);
    EXPECT_LT((three(row, 6) - c0 - t * p0 / mass - 0.5 * t * fall).norm(), 1e-5);
    EXPECT_LT((three(row, 9) + three(row, 12) - three(row, 0)).norm(), 1e-10);
    EXPECT_LT((three(row, 9) - 3 * three(row, 15)).norm(), 1e-10);
    bent = std::max(bent, row.modes.cwiseAbs().maxCoeff());
  }
  EXPECT_GT(bent, 1e-3);
}

/// A held beam in pieces: the name stands for all of them. What gravity and the joint do to it is the rate of
/// its momentum.
TEST_P(MomentumOutputs, OfABodyInPieces) {
  std::string text = beam;
  const std::string static_modes = "      static_modes: [{node: tip, along: [0, 0, 1]}]\n";
  text.replace(text.find(static_modes), static_modes.size(), "      substructures: 3\n");
  Simulation s =
      simulation(text + R"(
joints:
  hinge: {type: revolute, between: [ground, beam], at: [0, 0, 0], axis: [0, 1, 0]}
outputs:
)" + xyz("p", "linear_momentum: beam") +
                     xyz("c", "centre_of_mass: beam") + xyz("L", "angular_momentum: beam, about: [0, 0, 0]") +
                     xyz("all", "linear_momentum: all"),
                 0.001);
  const double mass = 1000 * std::numbers::pi * 0.05 * 0.05 / 4;
  ResultsRow row;
  s.sample(row);
  EXPECT_LT((three(row, 3) - Vector3d(0.5, 0, 0)).norm(), 1e-9);
  double moment = mass * 9.81 * three(row, 3)[0], turned = 0;
  Vector3d before = three(row, 3);
  for (int k = 0; k < 200; ++k) {
    ASSERT_TRUE(s.step().ok());
    s.sample(row);
    const Vector3d centre = three(row, 3);
    EXPECT_LT((three(row, 0) - three(row, 9)).norm(), 1e-12);
    // L̇ = c × m g about the hinge, by the trapezoidal rule; p = m ċ, by a difference in the middle.
    const double now = mass * 9.81 * centre[0];
    turned += 0.5 * 0.001 * (moment + now);
    moment = now;
    EXPECT_NEAR(three(row, 6)[1], turned, 2e-4 * (1 + std::abs(turned)));
    if (k > 100) {
      EXPECT_LT((three(row, 0) - mass * (centre - before) / 0.001).norm(), 0.05);
    }
    before = centre;
  }
}

INSTANTIATE_TEST_SUITE_P(Of, MomentumOutputs, testing::Values(Formulation::relative, Formulation::natural),
                         [](const auto& of) {
                           return of.param == Formulation::natural ? "natural" : "relative";
                         });

}  // namespace
}  // namespace mimbre::test::momentum_outputs_test
