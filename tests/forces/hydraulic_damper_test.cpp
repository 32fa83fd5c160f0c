#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/models.h"
#include "support/simulate.h"

/// Hydraulic dampers with compressible oil against closed forms of a mass on one. The force that they report
/// pushes.
namespace mimbre::hydraulic_damper_test {
namespace {

using namespace test;

class HydraulicDampers : public testing::TestWithParam<Formulation> {};

/// A mass of 2 kg on a slide along x between which and the ground the damper acts. K = 2 B A/l.
Simulation damped_mass(Formulation formulation, double damping, double quadratic, double bulk,
                       double velocity, double force, double step) {
  return simulation_of(model_of(fmt::format(R"y(
gravity: [0, 0, 0]
bodies: {{mass: {{mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}}}
joints: {{slide: {{type: prismatic, between: [ground, mass], at: [0.5, 0, 0], axis: [1, 0, 0], velocity: {}}}}}
loads: {{pull: {{on: mass, at: [0.5, 0, 0], force: [{}, 0, 0]}}}}
hydraulic_dampers:
  d: {{between: [ground, mass], at: [[0, 0, 0], [0.5, 0, 0]], damping: {}, quadratic: {}, area: 2 cm^2, length: 10 cm, bulk_modulus: {}}}
outputs: [{{name: v, joint_velocity: slide}}]
simulation: {{step: 0.001, end: 1}}
)y",
                                            velocity, force, damping, quadratic, bulk)),
                       formulation, step);
}

/// Without turbulence, m v̇ = −F and Ḟ = K (v − F/c): F = K v₀/ω e^(−λt) sin ωt, λ = K/2c, ω² = K/m − λ².
/// The error falls with the square of the step.
TEST_P(HydraulicDampers, OilSwingsAgainstTheMass) {
  const double K = 3200, c = 60, m = 2, v0 = 0.4, lambda = K / (2 * c),
               omega = std::sqrt(K / m - lambda * lambda);
  double errors[2];
  for (int k = 0; k < 2; ++k) {
    const double h = k == 0 ? 1e-3 : 5e-4;
    Simulation s = damped_mass(GetParam(), c, 0, K * 0.1 / (2 * 2e-4), v0, 0, h);
    double worst = 0;
    while (s.time() < 0.2) {
      ASSERT_TRUE(s.step().ok());
      const double exact = K * v0 / omega * std::exp(-lambda * s.time()) * std::sin(omega * s.time());
      worst = std::max(worst, std::abs(channel(s, "hydraulic_damper.d.force") + exact));
    }
    errors[k] = worst / (K * v0 / omega);
  }
  EXPECT_LT(errors[1], 1e-3);
  EXPECT_NEAR(errors[0] / errors[1], 4, 0.4);
}

/// Under a constant pull it goes at the speed at which the orifices resist as much: c v + d v² = f.
TEST_P(HydraulicDampers, ReachesTheSpeedOfItsOrifices) {
  const double c = 100, d = 400, f = 60;
  for (const double sign : {1.0, -1.0}) {
    Simulation s = damped_mass(GetParam(), c, d, 1.4e9, 0, sign * f, 1e-3);
    while (s.time() < 1) ASSERT_TRUE(s.step().ok());
    const double v = (-c + std::sqrt(c * c + 4 * d * f)) / (2 * d);
    EXPECT_NEAR(channel(s, "v"), sign * v, 1e-6 * v);
    EXPECT_NEAR(channel(s, "hydraulic_damper.d.force"), -sign * f, 1e-5 * f);
  }
}

/// Oil that gives next to nothing leaves the orifices alone, and does not ring however long the step is:
/// m v̇ = −c v − d v², v = v₀ e^(−ct/m)/(1 + d v₀/c (1 − e^(−ct/m))).
TEST_P(HydraulicDampers, StiffOilIsThatOfARigidDamper) {
  const double c = 20, d = 50, m = 2, v0 = 1;
  Simulation s = damped_mass(GetParam(), c, d, 1.4e15, v0, 0, 1e-3);
  while (s.time() < 0.3) {
    ASSERT_TRUE(s.step().ok());
    const double decay = std::exp(-c * s.time() / m), exact = v0 * decay / (1 + d * v0 / c * (1 - decay));
    if (s.time() < 0.02) continue;
    EXPECT_NEAR(channel(s, "v"), exact, 0.02 * v0) << s.time();
  }
}

/// What the orifices took and the oil holds is what the mass lost, with the order of the rule.
TEST_P(HydraulicDampers, KeepTheBalanceOfEnergy) {
  double open[2], dissipated = 0;
  for (int k = 0; k < 2; ++k) {
    Simulation s = damped_mass(GetParam(), 30, 200, 8e5, 2, 15, k == 0 ? 1e-3 : 5e-4);
    while (s.time() < 0.3 - 1e-9) ASSERT_TRUE(s.step().ok());
    open[k] = s.energy().numerical;
    dissipated = s.energy().dissipated;
  }
  EXPECT_GT(dissipated, 3);
  EXPECT_LT(std::abs(open[1]), 1e-4 * dissipated);
  EXPECT_NEAR(open[0] / open[1], 4, 0.8);
}

INSTANTIATE_TEST_SUITE_P(BothFormulations, HydraulicDampers,
                         testing::Values(Formulation::relative, Formulation::natural));

}  // namespace
}  // namespace mimbre::hydraulic_damper_test
