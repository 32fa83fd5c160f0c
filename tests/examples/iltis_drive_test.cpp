#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/models.h"
#include "support/simulate.h"

/// examples/iltis/drive.yaml: it drives, brakes, stands and steers, and nothing that is done to it breaks it.
namespace mimbre::examples_test::iltis_drive_test {
namespace {

using test::channel, test::run_to;

Simulation car() {
  return test::simulation_of(test::example("iltis/drive.yaml"), spec::Simulation::Formulation::relative);
}
void set(Simulation& s, const std::string& name, double value) { s.set_input(s.input(name), value); }

/// No tyre pushes more than friction allows; no more energy goes in than the engine's.
TEST(IltisDrive, AcceleratesBrakesAndStands) {
  Simulation s = car();
  set(s, "throttle", 1);
  run_to(s, 1);
  const double first = channel(s, "speed");
  EXPECT_GT(first, 8);
  EXPECT_LT(first, 5 + 0.9 * 9.81);
  set(s, "throttle", 0);
  set(s, "brake", 1);
  run_to(s, 2);
  EXPECT_LT(first - channel(s, "speed"), 0.9 * 9.81 * 1.02);
  run_to(s, 5);
  const double x = channel(s, "x"), z = channel(s, "z");
  EXPECT_NEAR(channel(s, "speed"), 0, 1e-3);
  run_to(s, 8);
  EXPECT_NEAR(channel(s, "x"), x, 1e-4);
  EXPECT_NEAR(channel(s, "z"), z, 1e-4);
  EXPECT_NEAR(channel(s, "y"), 0, 1e-3);
}

TEST(IltisDrive, SteersToWhereItIsSteered) {
  for (const double side : {1.0, -1.0}) {
    Simulation s = car();
    run_to(s, 0.5);
    set(s, "steering", 0.4 * side);
    run_to(s, 2.5);
    EXPECT_GT(side * channel(s, "yaw"), 0.15);
    EXPECT_GT(side * channel(s, "y"), 0.3);
    EXPECT_LT(side * channel(s, "roll"), 0.2);
  }
}

/// Whatever is done with wheel and pedals, at each half second something else.
TEST(IltisDrive, SurvivesAnyDriver) {
  Simulation s = car();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(0, 1);
  for (int k = 1; k <= 40; ++k) {
    set(s, "steering", 2 * any(random) - 1);
    set(s, "throttle", any(random));
    set(s, "brake", any(random) < 0.3 ? any(random) : 0);
    run_to(s, 0.5 * k);
    for (const char* name : {"x", "y", "z", "roll", "tyre.front_left.tyre.lateral"})
      ASSERT_TRUE(std::isfinite(channel(s, name))) << name << " " << k;
    ASSERT_LT(std::abs(channel(s, "z")), 10);
  }
  const EnergyBalance e = s.energy();
  EXPECT_LT(std::abs(e.numerical), 0.02 * (e.dissipated + 1e4));
}

}  // namespace
}  // namespace mimbre::examples_test::iltis_drive_test
