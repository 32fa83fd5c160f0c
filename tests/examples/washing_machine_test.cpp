#include <cmath>
#include <complex>
#include <numbers>

#include "examples/example.h"

/// examples/washing-machine against a mass on a spring that an unbalance shakes.
namespace mimbre::examples_test::washing_machine_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double unbalance = 0.5, eccentricity = 0.24, mass = 40.5;
constexpr double stiffness = 4 * 3600, damping = 4 * 40;  // upwards; 0.8 of it sideways

/// m e ω²/|k − M ω² + i c ω|, m
double shaken(double speed, double share) {
  const std::complex<double> i(0, 1);
  return unbalance * eccentricity * speed * speed /
         std::abs(share * stiffness - mass * speed * speed + i * share * damping * speed);
}

class WashingMachine : public ExampleTest {};

TEST_F(WashingMachine, SagsByItsWeight) {
  const app_test::Outcome outcome = run({"static", model_of("washing-machine").string(), "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NEAR(outcome.json().at("outputs").at("tub.z"), -mass * 9.81 / stiffness, 1e-9);
}

TEST_F(WashingMachine, SpinsAboveItsResonancesWithTheUnbalanceOverTheMass) {
  const Table last = run_example("washing-machine", {"--until", "12"}).from(11);
  const double speed = 40 * pi;
  EXPECT_NEAR(last["drum.speed"].mean(), speed, 1e-6);
  EXPECT_NEAR(amplitude(last["tub.z"]), shaken(speed, 1), 0.02 * shaken(speed, 1));
  EXPECT_NEAR(amplitude(last["tub.x"]), shaken(speed, 0.8), 0.02 * shaken(speed, 0.8));
  // Far above the resonance the axis of inertia stays, and the tub goes round it.
  EXPECT_NEAR(shaken(speed, 1), unbalance * eccentricity / mass, 0.03 * unbalance * eccentricity / mass);
}

TEST_F(WashingMachine, SwingsMostNearTheBounceFrequency) {
  const double bounce = std::sqrt(stiffness / mass) / (2 * pi);
  EXPECT_NEAR(bounce, 3.0, 0.01) << "examples/washing-machine/README.md says so";
  const Table run = run_example("washing-machine");
  Eigen::Index row = 0;
  const Eigen::ArrayXd height = run["tub.z"] + mass * 9.81 / stiffness;
  const double highest = height.abs().maxCoeff(&row);
  // Run through, a resonance comes late and does not grow to what it would be at rest in it.
  EXPECT_GT(run["drum.speed"][row] / (2 * pi), bounce);
  EXPECT_LT(run["drum.speed"][row] / (2 * pi), 1.7 * bounce);
  EXPECT_LT(highest, shaken(2 * pi * bounce, 1));
  EXPECT_GT(highest, 2 * shaken(40 * pi, 1));
}

}  // namespace
}  // namespace mimbre::examples_test::washing_machine_test
