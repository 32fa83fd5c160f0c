#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "mimbre/simulation.h"
#include "mimbre/statics.h"
#include "support/models.h"
#include "support/random_mechanism.h"
#include "support/simulate.h"

/// Wheels, balls and edges whose velocities are constrained, against closed equations of motion.
namespace mimbre::test::rolling_test {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

constexpr double mass = 2, radius = 0.3, transverse = 0.05, axial = 0.08, g = 9.81;

class Rolling : public testing::TestWithParam<Formulation> {
 protected:
  Simulation simulation(const std::string& text, double step) const {
    return precise_simulation_of(text, GetParam(), step);
  }
};
INSTANTIATE_TEST_SUITE_P(Formulations, Rolling, testing::Values(Formulation::relative, Formulation::natural),
                         [](const auto& of) {
                           return of.param == Formulation::natural ? "natural" : "relative";
                         });

std::string list(const Vector3d& v) { return fmt::format("[{}, {}, {}]", v[0], v[1], v[2]); }

/// A wheel with its axis along e, which touches the plane z = 0 and turns with omega.
std::string wheel(const Vector3d& e, const Vector3d& omega, double crown = 0) {
  const double height = (radius - crown) * std::sqrt(1 - e[2] * e[2]) + crown;
  const Eigen::Matrix3d I =
      transverse * Eigen::Matrix3d::Identity() + (axial - transverse) * e * e.transpose();
  return fmt::format(R"(
bodies:
  disc: {{mass: {}, com: [0, 0, {}], inertia: [{}, {}, {}, {}, {}, {}]}}
joints:
  free: {{type: floating, between: [ground, disc], at: [0, 0, {}],
         velocity: [null, null, null, {}, {}, {}]}}
constraints:
  rim: {{type: rolling, between: [ground, disc], at: [[0, 0, 0], [0, 0, {}]], axis: [0, 0, 1], axis2: {},
        radius: {}, crown: {}}}
outputs:
  - {{name: wx, angular_velocity: disc, component: x}}
  - {{name: wy, angular_velocity: disc, component: y}}
  - {{name: wz, angular_velocity: disc, component: z}}
)",
                     mass, height, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2), height, omega[0],
                     omega[1], omega[2], height, list(e), radius, crown);
}

/// Inclination θ of the axis to the vertical, its rate, precession and spin about the axis, by
///     (It + m R²) θ̈ = It ψ̇² sin θ cos θ − (Ia + m R²) ω₃ ψ̇ sin θ − m g R cos θ
///     It (ψ̈ sin θ + 2 ψ̇ θ̇ cos θ) = Ia ω₃ θ̇
///     (Ia + m R²) ω̇₃ = m R² θ̇ ψ̇ sin θ
/// (O'Reilly 1996) and the classical method of order 4.
using Disc = Eigen::Vector4d;
Disc rate_of(const Disc& x) {
  const double s = std::sin(x[0]), c = std::cos(x[0]), mr2 = mass * radius * radius;
  const double theta2 =
      (transverse * x[2] * x[2] * s * c - (axial + mr2) * x[3] * x[2] * s - mass * g * radius * c) /
      (transverse + mr2);
  return {x[1], theta2, (axial * x[3] * x[1] / transverse - 2 * x[2] * x[1] * c) / s,
          mr2 * x[1] * x[2] * s / (axial + mr2)};
}
Disc after(Disc x, double time) {
  const int steps = 4000;
  const double h = time / steps;
  for (int k = 0; k < steps; ++k) {
    const Disc a = rate_of(x), b = rate_of(x + h / 2 * a), c = rate_of(x + h / 2 * b), d = rate_of(x + h * c);
    x += h / 6 * (a + 2 * b + 2 * c + d);
  }
  return x;
}
Disc seen(const Vector3d& e, const Vector3d& omega) {
  const double c = e[2], s = std::sqrt(1 - c * c);
  const double up = (omega[2] - c * omega.dot(e)) / s;
  return {std::acos(c), -omega.cross(e)[2] / s, up / s, omega.dot(e)};
}
Vector3d spin(Simulation& s) { return {channel(s, "wx"), channel(s, "wy"), channel(s, "wz")}; }
Vector3d axis_now(Simulation& s, const Vector3d& e) { return s.pose(s.body("disc")).rotation * e; }

TEST_P(Rolling, ADiscMovesByItsClosedEquationsWithTheSquareOfTheStep) {
  const Vector3d e = Vector3d(0.2, 0.9, 0.35).normalized(), omega(0.4, 7, 0.8);
  const Disc expected = after(seen(e, omega), 1);
  double errors[2];
  for (int k = 0; k < 2; ++k) {
    Simulation s = simulation(wheel(e, omega), k == 0 ? 0.004 : 0.002);
    EXPECT_EQ(s.degrees_of_freedom(), 3);
    run_to(s, 1);
    errors[k] = (seen(axis_now(s, e), spin(s)) - expected).cwiseAbs().maxCoeff();
  }
  EXPECT_LT(errors[1], 2e-3);
  EXPECT_NEAR(errors[0] / errors[1], 4, 0.8);
}

TEST_P(Rolling, ADiscKeepsRollingInACircle) {
  // Steady: θ̈ = 0 decides the spin to an inclination and a precession.
  const double theta = 1.2, precession = 1.5, s = std::sin(theta), c = std::cos(theta),
               mr2 = mass * radius * radius;
  const double roll = (transverse * precession * precession * s * c - mass * g * radius * c) /
                      ((axial + mr2) * precession * s);
  const Vector3d e(0, s, c), up(0, -c, s);
  const double period = 2 * pi / precession;
  Disc errors[2];
  for (int k = 0; k < 2; ++k) {
    Simulation run = simulation(wheel(e, roll * e + precession * s * up), period / (k == 0 ? 1000 : 2000));
    run_to(run, period);
    errors[k] = seen(axis_now(run, e), spin(run)) - Disc(theta, 0, precession, roll);
    if (k == 0) continue;
    EXPECT_LT(errors[k].cwiseAbs().maxCoeff(), 2e-4);
    // Once around the circle.
    EXPECT_LT((axis_now(run, e) - e).norm(), 2e-4);
    const spec::Pose pose = run.pose(run.body("disc"));
    EXPECT_LT(pose.position.head<2>().norm(), 1e-3 * radius * std::abs(roll) / precession);
  }
  EXPECT_NEAR(errors[0].norm() / errors[1].norm(), 4, 0.5);
}

TEST_P(Rolling, KeepsTheEnergyFromManyStarts) {
  Random random(7);
  const int starts = 500;  // in each formulation
  for (int k = 0; k < starts; ++k) {
    Vector3d e = random.vector(1);
    if (std::abs(e.normalized()[2]) > 0.8) e[2] = 0.1;
    e.normalize();
    const Vector3d omega = random.vector(5);
    Simulation s = simulation(wheel(e, omega, random.chance(0.5) ? random.number(0, radius) : 0), 0.002);
    const EnergyBalance start = s.energy();
    const double at_play = mass * g * radius + start.kinetic;
    for (int step = 0; step < 25; ++step) ASSERT_TRUE(s.step().ok()) << k;
    EXPECT_LT(std::abs(s.energy().numerical), 2e-3 * at_play) << k;
  }
}

/// v̇ = 2/7 Ω × v (Milne 1948). The ball starts at 0.1 m/s along x, rolling: by its turning alone.
TEST_P(Rolling, ABallOnATurntableGoesInTheKnownCircle) {
  const double turn = 4, rate = 2.0 / 7 * turn, r = 0.05, inertia = 0.4 * 0.3 * r * r;
  const std::string text = fmt::format(R"(
bodies:
  table: {{mass: 5, com: [0, 0, 0], inertia: [1, 1, 1]}}
  ball: {{mass: 0.3, com: [0.2, 0, {0}], inertia: [{1}, {1}, {1}]}}
joints:
  spindle: {{type: revolute, between: [ground, table], at: [0, 0, 0], axis: [0, 0, 1], drive: {{speed: {2}}}}}
  free: {{type: floating, between: [ground, ball], at: [0.2, 0, {0}], velocity: [null, null, null, 16, 2, 0]}}
constraints:
  rim: {{type: rolling, between: [table, ball], at: [[0, 0, 0], [0.2, 0, {0}]], axis: [0, 0, 1], axis2: [0, 1, 0],
        radius: {0}, crown: {0}}}
)",
                                       r, inertia, turn);
  const double x = 0.2 + 0.1 / rate * std::sin(3 * rate), y = 0.1 / rate * (1 - std::cos(3 * rate));
  double errors[2];
  for (int k = 0; k < 2; ++k) {
    Simulation s = simulation(text, k == 0 ? 0.002 : 0.001);
    run_to(s, 3);
    const Vector3d p = s.pose(s.body("ball")).position;
    errors[k] = (p.head<2>() - Eigen::Vector2d(x, y)).norm();
    EXPECT_NEAR(p[2], r, 1e-9);
  }
  EXPECT_LT(errors[1], 1e-4);
  EXPECT_NEAR(errors[0] / errors[1], 4, 0.5);
}

/// A skate that turns evenly on a slope goes along a cycloid (Neimark, Fufaev 1972).
TEST_P(Rolling, AnEdgeOnASlopeGoesAlongACycloid) {
  const double down = 3, turn = 2;
  Simulation s = simulation(fmt::format(R"(
gravity: [{}, 0, -9]
bodies:
  skate: {{mass: 1.5, com: [0, 0, 0], inertia: [0.1, 0.1, 0.1]}}
joints:
  ice: {{type: planar, between: [ground, skate], at: [0, 0, 0], axis: [0, 0, 1], velocity: [null, null, {}]}}
constraints:
  edge: {{type: knife_edge, between: [ground, skate], at: [0, 0, 0], axis: [0, 1, 0]}}
)",
                                        down, turn),
                            0.001);
  run_to(s, 2);
  const Vector3d p = s.pose(s.body("skate")).position;
  const double factor = down / (2 * turn * turn), angle = 2 * turn;
  EXPECT_NEAR(p[0], factor * std::sin(angle) * std::sin(angle), 1e-5);
  EXPECT_NEAR(p[1], factor * (angle - 0.5 * std::sin(2 * angle)), 1e-5);
}

/// Chaplygin's sleigh: v̇ = a ω², (I + m a²) ω̇ = −m a v ω, so that v = V tanh(k t + c).
TEST_P(Rolling, ChaplyginsSleighComesToRunStraight) {
  const double m = 1.5, a = 0.2, inertia = 0.1, whole = inertia + m * a * a, omega = 3;
  Simulation s = simulation(fmt::format(R"(
gravity: [0, 0, 0]
bodies:
  sleigh: {{mass: {}, com: [{}, 0, 0], inertia: [0.1, 0.1, {}]}}
joints:
  ice: {{type: planar, between: [ground, sleigh], at: [0, 0, 0], axis: [0, 0, 1], velocity: [0, null, {}]}}
constraints:
  edge: {{type: knife_edge, between: [ground, sleigh], at: [0, 0, 0], axis: [0, 1, 0]}}
outputs:
  - {{name: vx, velocity: sleigh, component: x}}
  - {{name: vy, velocity: sleigh, component: y}}
)",
                                        m, a, inertia, omega),
                            0.001);
  run_to(s, 2);
  const double speed = std::sqrt(whole / m) * omega, k = a * m * speed / whole;
  const Vector3d heading = s.pose(s.body("sleigh")).rotation.col(0);
  const Vector3d v(channel(s, "vx"), channel(s, "vy"), 0);
  EXPECT_NEAR(heading.dot(v), speed * std::tanh(2 * k), 2e-5);
  EXPECT_NEAR(heading.cross(v)[2], a * omega / std::cosh(2 * k), 2e-5);  // of its centre
}

/// The constraint's force and moment at the centre are those of the contact: normal force and friction.
TEST_P(Rolling, ReactionsAreThoseOfTheContact) {
  // Rolls straight, driven by a torque about its axis: m a R = T − Ia α with a = R α.
  Simulation s = simulation(fmt::format(R"(
bodies:
  disc: {{mass: {0}, com: [0, 0, {1}], inertia: [{2}, {3}, {2}]}}
joints:
  free: {{type: floating, between: [ground, disc], at: [0, 0, {1}]}}
constraints:
  rim: {{type: rolling, between: [ground, disc], at: [[0, 0, 0], [0, 0, {1}]], axis: [0, 0, 1], axis2: [0, 1, 0],
        radius: {1}}}
loads:
  torque: {{on: disc, moment: [0, 0.6, 0]}}
outputs:
  - {{name: vx, velocity: disc, component: x}}
)",
                                        mass, radius, transverse, axial),
                            0.01);
  run_to(s, 1);
  const double alpha = 0.6 / (axial + mass * radius * radius), push = mass * radius * alpha;
  EXPECT_NEAR(channel(s, "constraint.rim.force.x"), push, 1e-8);
  EXPECT_NEAR(channel(s, "constraint.rim.force.z"), mass * g, 1e-8);
  EXPECT_NEAR(channel(s, "constraint.rim.moment.y"), -push * radius, 1e-8);
  // In natural coordinates turning has an error of the second order.
  EXPECT_NEAR(s.pose(s.body("disc")).position[0], 0.5 * radius * alpha,
              GetParam() == Formulation::natural ? 1e-5 : 1e-8);
}

/// In an equilibrium the wheel is held by friction, and got there by rolling.
TEST(RollingWheel, RestsWhereItsEccentricMassIsLowest) {
  const StaticResult rest = static_equilibrium(model_of(R"(
bodies:
  disc: {mass: 2, com: [0.1, 0, 0.3], inertia: [0.05, 0.08, 0.05]}
joints:
  plane: {type: planar, between: [ground, disc], at: [0, 0, 0.3], axis: [0, 1, 0]}
constraints:
  rim: {type: rolling, between: [ground, disc], at: [[0, 0, 0], [0, 0, 0.3]], axis: [0, 0, 1], axis2: [0, 1, 0],
        radius: 0.3}
outputs:
  - {name: x, position: disc, component: x}
)"));
  ASSERT_EQ(rest.output_count, 1);
  EXPECT_TRUE(rest.stable);
  // A quarter of a turn about y, rolled without slip; the disc's origin is its centre.
  EXPECT_NEAR(rest.values[0], radius * pi / 2, 1e-10);
}

}  // namespace
}  // namespace mimbre::test::rolling_test
