#include <cmath>
#include <numbers>

#include "examples/example.h"

/// examples/rotor against Laval's: a disc on a spring without mass, shaken by its eccentricity.
namespace mimbre::examples_test::rotor_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double disc = 4, eccentricity = 5e-5, damping = 24, length = 0.5, diameter = 0.012;

/// 48 E I/l³ of the shaft on its two bearings, and of its own mass the 17/35 that move along.
double stiffness() {
  const double shaft = 48 * 2.1e11 * pi / 64 * std::pow(diameter, 4) / std::pow(length, 3);
  return 1 / (1 / shaft + 1 / (2 * 5e7));
}
double mass() { return disc + 17.0 / 35 * 7850 * pi / 4 * diameter * diameter * length; }
double critical() { return std::sqrt(stiffness() / mass()); }  ///< rad/s
/// Of the whirl at a constant speed, m.
double whirl(double speed) {
  return disc * eccentricity * speed * speed /
         std::hypot(stiffness() - mass() * speed * speed, damping * speed);
}

class Rotor : public ExampleTest {
 protected:
  /// Of the disc's height at a constant speed after what the start has left.
  double whirl_of_run(double speed) const {
    const std::string rpm = std::to_string(speed * 30 / pi);
    const Table last =
        run_example("rotor", {"--set", "rpm=" + rpm, "--set", "ramp=1", "--until", "4"}).from(3.5);
    return amplitude(last["disc.z"]);
  }
};

TEST_F(Rotor, HangsAsABeamDoes) {
  const app_test::Outcome outcome = run({"static", model_of("rotor").string(), "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  // Half of an even load bends a beam as 5/8 of it in the middle.
  const double sag = 9.81 * (disc + 5.0 / 8 * 7850 * pi / 4 * diameter * diameter * length) / stiffness();
  EXPECT_NEAR(outcome.json().at("outputs").at("disc.z"), -sag, 2e-3 * sag);
}

TEST_F(Rotor, WhirlsAtItsCriticalSpeedAsItsDampingLets) {
  EXPECT_NEAR(critical() * 30 / pi, 1332, 1) << "examples/rotor/README.md says so";
  EXPECT_NEAR(whirl(critical()), 1.16e-3, 0.01e-3) << "examples/rotor/README.md says so";
  EXPECT_NEAR(whirl_of_run(critical()), whirl(critical()), 0.02 * whirl(critical()));
}

TEST_F(Rotor, CentresItselfAboveIt) {
  for (const double part : {0.7, 1.5})
    EXPECT_NEAR(whirl_of_run(part * critical()), whirl(part * critical()), 0.02 * whirl(part * critical()));
}

/// The flank of the resonance on both sides of the peak, where an error of the speed would show.
TEST_F(Rotor, HasItsCriticalSpeedWhereTheBeamSays) {
  const double below = whirl_of_run(0.98 * critical()), above = whirl_of_run(1.02 * critical());
  EXPECT_NEAR(below, whirl(0.98 * critical()), 0.05 * below);
  EXPECT_NEAR(above, whirl(1.02 * critical()), 0.05 * above);
}

TEST_F(Rotor, RunsThroughItWithLess) {
  const Table run = run_example("rotor");
  Eigen::Index row = 0;
  const double most = run["disc.y"].abs().maxCoeff(&row);
  EXPECT_GT(run["shaft.speed"][row], critical());
  EXPECT_LT(run["shaft.speed"][row], 1.15 * critical());
  EXPECT_LT(most, whirl(critical()));
  EXPECT_GT(most, 0.5 * whirl(critical()));
}

}  // namespace
}  // namespace mimbre::examples_test::rotor_test
