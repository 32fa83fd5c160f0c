#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "forces/measure_turning.h"
#include "mimbre/simulation.h"
#include "support/models.h"
#include "support/random_mechanism.h"
#include "support/simulate.h"

/// Bushings, and torques about axes, through any number of turns.
namespace mimbre::test::turning_test {
namespace {

using std::numbers::pi;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using States = std::array<double, turning::count>;

/// Turned by `angle` about n from where the states are, in small steps.
void turn(const Vec3d& n, double angle, Mat3d& rotation, States& states) {
  const int steps = 1 + static_cast<int>(std::abs(angle) / 0.1);
  for (int k = 0; k < steps; ++k) {
    rotation = rotation_exp<double>(Vec3d(angle / steps * n)) * rotation;
    States next;
    turning::measure<double>(rotation, states.data(), next.data());
    states = next;
  }
}

struct Measured {
  Vec3d x;
  Mat3d by_spin;
};
Measured measured(const Mat3d& rotation, const States& states) {
  States next;
  const auto turned = turning::measure<double>(rotation, states.data(), next.data());
  return {turned.x, turned.by_spin};
}

/// About an axis alone the measure is its angle, and the rate of that the spin.
TEST(Turning, CountsTurnsAboutAnyAxis) {
  Random random(3);
  for (int round = 0; round < 50; ++round) {
    const Vec3d n = random.vector(1).normalized();
    Mat3d rotation = Mat3d::Identity();
    States states{};
    for (double angle = 0; const double part : {1.0, 2.1, 0.3, 3.0, 12.0, -14.0, -9.5}) {
      turn(n, part, rotation, states);
      angle += part;
      const Measured m = measured(rotation, states);
      EXPECT_LT((m.x - angle * n).norm(), 1e-12) << angle;
      EXPECT_LT((m.by_spin * n - n).norm(), 1e-12) << angle;
    }
  }
}

/// ẋ = by_spin · ω, so that the torque of any energy of x is its gradient: through half a turn, whole turns
/// and many, tilted from the axis and not.
TEST(Turning, RatesAreDerivativesAtAnyAngle) {
  Random random(5);
  for (int round = 0; round < 400; ++round) {
    const Vec3d n = random.vector(1).normalized();
    Mat3d rotation = Mat3d::Identity();
    States states{};
    const double angles[] = {0.4, 3.0, pi - 1e-3, pi, pi + 1e-3, 4.5, 2 * pi, 5 * pi, -5 * pi, 30.0};
    turn(n, angles[round % 10], rotation, states);
    turn(n.cross(random.vector(1)).normalized(), round % 3 == 0 ? 0 : random.number(0, 0.8), rotation,
         states);
    const Measured here = measured(rotation, states);
    const double h = 1e-6;
    for (int k = 0; k < 3; ++k) {
      const Vec3d spin = Vec3d::Unit(k);
      const Vec3d up = measured(rotation_exp<double>(Vec3d(h * spin)) * rotation, states).x,
                  down = measured(rotation_exp<double>(Vec3d(-h * spin)) * rotation, states).x;
      EXPECT_LT((here.by_spin * spin - (up - down) / (2 * h)).norm(), 1e-8 * (1 + here.by_spin.norm()))
          << round << " " << k;
    }
  }
}

/// Where the axis is kept, at half a turn, neither what is measured nor its rates jump.
TEST(Turning, PassesHalfATurnContinuously) {
  Random random(7);
  for (int round = 0; round < 100; ++round) {
    const Vec3d n = random.vector(1).normalized();
    Mat3d rotation = Mat3d::Identity();
    States before{};
    turn(n, pi - 0.05, rotation, before);
    rotation = rotation_exp<double>(Vec3d(0.07 * n)) * rotation;
    const Measured by_vector = measured(rotation, before);
    States kept;
    turning::measure<double>(rotation, before.data(), kept.data());
    ASSERT_GT(Vec3d(kept[4], kept[5], kept[6]).norm(), pi);
    const Measured about_axis = measured(rotation, kept);
    EXPECT_LT((by_vector.x - about_axis.x).norm(), 1e-14);
    EXPECT_LT((by_vector.by_spin - about_axis.by_spin).norm(), 1e-13);
  }
}

/// Up to half a turn the measure is the rotation vector, to the bit as if nothing were remembered.
TEST(Turning, IsTheRotationVectorUpToHalfATurn) {
  Random random(9);
  for (int round = 0; round < 100; ++round) {
    const Vec3d theta = random.number(0, 3.1) * random.vector(1).normalized();
    Mat3d rotation = Mat3d::Identity();
    States states{};
    turn(theta.normalized(), theta.norm(), rotation, states);
    EXPECT_LT((measured(rotation, states).x - theta).norm(), 1e-12);
    EXPECT_EQ(measured(rotation, states).x, quaternion_log<double>(quaternion_of(rotation)));
  }
}

class TurningRuns : public testing::TestWithParam<Formulation> {
 protected:
  /// Natural coordinates turn by unit vectors: an angle has the rule's error.
  static bool natural() { return GetParam() == Formulation::natural; }
};

/// A hinge with a bushing of 1 N m/rad, turned by ±`speed` rad: a = speed · sin t.
std::string hinge(double speed, const std::string& axis = "[0, 0, 1]",
                  const std::string& stiffness = "[0, 0, 0, 0, 0, 1]") {
  return fmt::format(R"(
gravity: [0, 0, 0]
bodies: {{b: {{mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}}}
joints: {{j: {{type: revolute, between: [ground, b], at: [0, 0, 0], axis: {}, velocity: [{}]}}}}
bushings: {{g: {{between: [ground, b], at: [0, 0, 0], stiffness: {}}}}}
outputs: [{{name: a, joint: j}}]
simulation: {{step: 0.001}}
)",
                     axis, speed, stiffness);
}

TEST_P(TurningRuns, AHingedBushingSwingsThroughManyTurns) {
  for (const double speed : {4.0, 40.0}) {
    const double close = natural() ? 2e-6 * speed * speed * speed : 2e-6 * speed;
    Simulation s = simulation_of(hinge(speed), GetParam());
    for (int k = 1; k <= 12; ++k) {
      run_to(s, 0.5 * k);
      EXPECT_NEAR(channel(s, "a"), speed * std::sin(0.5 * k), close) << speed << " " << k;
      EXPECT_NEAR(channel(s, "bushing.g.measure.rz"), channel(s, "a"), 1e-9 * speed);
      EXPECT_NEAR(channel(s, "bushing.g.force.rz"), -channel(s, "a"), 1e-9 * speed);
    }
    EXPECT_LT(std::abs(s.energy().numerical), close * speed);
    EXPECT_THAT(s.warnings(), IsEmpty());
  }
}

/// About an axis between those of the bushing, whose stiffnesses differ, the energy of the angle is that of n
/// · K n, however far it turns.
TEST_P(TurningRuns, AnyAxisHasItsStiffness) {
  Simulation s = simulation_of(hinge(10, "[0.6, 0, 0.8]", "[0, 0, 0, 2, 3, 0.5]"), GetParam());
  const double rate = std::sqrt(0.36 * 2 + 0.64 * 0.5);
  for (int k = 1; k <= 8; ++k) {
    run_to(s, 0.5 * k);
    EXPECT_NEAR(channel(s, "a"), 10 / rate * std::sin(0.5 * rate * k), natural() ? 1e-3 : 3e-5) << k;
  }
}

/// A body in space that winds up a bushing, tilting as it does: its energy is kept to the rule's error.
std::string top() {
  return R"(
gravity: [0, 0, 0]
bodies: {b: {mass: 1, com: [0, 0, 0], inertia: [1, 1.2, 0.8]}}
joints: {f: {type: floating, between: [ground, b], at: [0, 0, 0], velocity: [0.1, 0.2, -0.1, 0.2, -0.1, 16]}}
bushings: {g: {between: [ground, b], at: [0, 0, 0.1], stiffness: [50, 60, 70, 40, 50, 1]}}
outputs:
  - {name: wx, angular_velocity: b, component: x}
  - {name: wz, angular_velocity: b, component: z}
simulation: {step: 0.001}
)";
}

TEST_P(TurningRuns, AFreeBodyKeepsItsEnergyThroughTurns) {
  double coarse = 0;
  for (const double step : {1e-3, 5e-4}) {
    RunOptions options;
    options.formulation = GetParam();
    options.step = step;
    options.integrator = spec::Simulation::Integrator::newmark;
    options.energies = true;
    Simulation s(model_of(top()), options);
    double largest = 0, most = 0;
    while (s.time() < 3) {
      ASSERT_TRUE(s.step().ok());
      largest = std::max(largest, std::abs(s.energy().numerical));
      most = std::max(most, channel(s, "bushing.g.measure.rz"));
    }
    EXPECT_GT(most, 4 * pi);
    if (coarse == 0) coarse = largest;
    EXPECT_LT(largest, 1e-3 * 128);
    if (step < 1e-3) {
      EXPECT_GT(coarse / largest, 3);
    }
  }
}

TEST(Turning, FormulationsAgreeThroughTurns) {
  Simulation relative = simulation_of(top(), Formulation::relative),
             natural = simulation_of(top(), Formulation::natural);
  for (int k = 1; k <= 6; ++k) {
    run_to(relative, 0.5 * k);
    run_to(natural, 0.5 * k);
    for (const char* const name : {"wx", "wz"})
      EXPECT_NEAR(channel(relative, name), channel(natural, name), 2e-3) << name << k;
  }
}

/// What remembers the turns is saved.
TEST_P(TurningRuns, ASavedStateGoesOnWithTheSameTurns) {
  Simulation one = simulation_of(top(), GetParam()), other = simulation_of(top(), GetParam());
  run_to(one, 1.2);
  other.restore(one.save());
  run_to(one, 2);
  run_to(other, 2);
  EXPECT_EQ(channel(one, "bushing.g.measure.rz"), channel(other, "bushing.g.measure.rz"));
  EXPECT_EQ(channel(one, "wx"), channel(other, "wx"));
}

/// A large tilt away from what is turned about is told; small ones, and turning about one axis, are not.
TEST_P(TurningRuns, LargeTiltsAreTold) {
  const auto told = [&](const std::string& spin) {
    Simulation s = simulation_of(fmt::format(R"(
gravity: [0, 0, 0]
bodies: {{b: {{mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}}}
joints: {{f: {{type: floating, between: [ground, b], at: [0, 0, 0], velocity: [0, 0, 0, {}]}}}}
bushings: {{g: {{between: [ground, b], at: [0, 0, 0], stiffness: [10, 10, 10, 2, 2, 0.5]}}}}
simulation: {{step: 0.002}}
)",
                                             spin),
                                 GetParam());
    run_to(s, 2);
    return s.warnings();
  };
  EXPECT_THAT(told("0, 0, 6"), IsEmpty());
  EXPECT_THAT(told("0.1, 0.1, 0.5"), IsEmpty());
  const std::vector<std::string> warnings = told("2, 0, 3");
  ASSERT_THAT(warnings, SizeIs(1));
  EXPECT_THAT(warnings[0], HasSubstr("bushing 'g' turned by"));
}

INSTANTIATE_TEST_SUITE_P(Both, TurningRuns, testing::Values(Formulation::relative, Formulation::natural),
                         [](const auto& given) {
                           return given.param == Formulation::relative ? "relative" : "natural";
                         });

}  // namespace
}  // namespace mimbre::test::turning_test
