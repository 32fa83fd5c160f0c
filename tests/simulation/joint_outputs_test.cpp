#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "support/models.h"
#include "support/simulate.h"

/// Rotations, quaternions and accelerations of joints as outputs, against motions that are known.
namespace mimbre::test::joint_outputs_test {
namespace {

class JointOutputs : public testing::TestWithParam<Formulation> {};

std::string of_ball(const std::string& body, const std::string& velocity, const std::string& gravity,
                    double step) {
  std::string outputs;
  for (const char axis : {'x', 'y', 'z'})
    outputs += fmt::format("  - {{name: r{0}, joint_rotation: ball, component: {0}}}\n", axis);
  for (const char part : {'w', 'x', 'y', 'z'})
    outputs += fmt::format("  - {{name: q{0}, joint_quaternion: ball, component: {0}}}\n", part);
  for (const int k : {0, 1, 2})
    outputs += fmt::format(
        "  - {{name: w{0}, joint_velocity: ball, component: {0}}}\n"
        "  - {{name: a{0}, joint_acceleration: ball, component: {0}}}\n",
        k);
  return fmt::format(R"y(
gravity: {}
bodies: {{top: {}}}
joints: {{ball: {{type: spherical, between: [ground, top], at: [0, 0, 0], velocity: {}}}}}
outputs:
{}simulation: {{step: {}, end: 2, integrator: {{type: generalized_alpha, rho: 1}}}}
)y",
                     gravity, body, velocity, outputs, step);
}

Eigen::Vector3d three(Simulation& s, const char* format) {
  Eigen::Vector3d v;
  for (int k = 0; k < 3; ++k)
    v[k] = channel(
        s, fmt::format(fmt::runtime(format), format[0] == 'r' ? "xyz"[k] : static_cast<char>('0' + k)));
  return v;
}

/// The turn that both outputs say, which must be the same.
Eigen::Quaterniond turn_of(Simulation& s) {
  const Eigen::Quaterniond q(channel(s, "qw"), channel(s, "qx"), channel(s, "qy"), channel(s, "qz"));
  EXPECT_NEAR(q.norm(), 1, 1e-12);
  const Eigen::Vector3d r = three(s, "r{}");
  EXPECT_LE(r.norm(), M_PI + 1e-12);
  const Eigen::Quaterniond by_vector(Eigen::AngleAxisd(r.norm(), r.normalized()));
  EXPECT_NEAR(std::abs(by_vector.dot(q)), 1, 1e-12);
  return q;
}

/// A body that carries equal inertia about all axes turns evenly, on beyond half a turn.
TEST_P(JointOutputs, AnEvenTurn) {
  const Eigen::Vector3d speed(1.5, -2, 1);
  Simulation s = simulation_of(
      of_ball("{mass: 2, com: [0, 0, 0], inertia: [0.3, 0.3, 0.3]}", "[1.5, -2, 1]", "[0, 0, 0]", 0.001),
      GetParam());
  for (const double end : {0.3, 0.9, 1.5, 2.0}) {
    run_to(s, end);
    const Eigen::Quaterniond exact(Eigen::AngleAxisd(speed.norm() * end, speed.normalized()));
    EXPECT_LT(turn_of(s).angularDistance(exact), 1e-5) << end;
    // Of an angle of at most π: the other way round where it is more.
    const double angle = std::remainder(speed.norm() * end, 2 * M_PI);
    EXPECT_LT((three(s, "r{}") - angle * speed.normalized()).norm(), 1e-5) << end;
    EXPECT_LT(three(s, "a{}").norm(), 1e-6);
  }
}

/// Poinsot's motion of a symmetric top: about its angular momentum at L/I₁, and about its own axis at
/// (1 − I₃/I₁) ω₃. Rates and accelerations are in the top's axes.
TEST_P(JointOutputs, ASpinningTop) {
  const double i1 = 0.2, i3 = 0.35, w3 = 6;
  const Eigen::Vector3d start(1, 0, w3), momentum(i1 * start[0], 0, i3 * w3);
  double before = 0;
  for (const double step : {2e-3, 1e-3}) {
    Simulation s = simulation_of(
        of_ball("{mass: 1, com: [0, 0, 0], inertia: [0.2, 0.2, 0.35]}", "[1, 0, 6]", "[0, 0, 0]", step),
        GetParam());
    const double t = 0.7;
    run_to(s, t);
    const Eigen::Quaterniond exact = Eigen::AngleAxisd(momentum.norm() / i1 * t, momentum.normalized()) *
                                     Eigen::AngleAxisd((1 - i3 / i1) * w3 * t, Eigen::Vector3d::UnitZ());
    const double off = turn_of(s).angularDistance(exact);
    EXPECT_LT(off, 100 * step * step);
    // By the rule's order with the step.
    if (before > 0) {
      EXPECT_NEAR(before / off, 4, 0.3);
    }
    before = off;
    const double turning = (i3 - i1) / i1 * w3, phase = turning * t;
    const Eigen::Vector3d rates(std::cos(phase), std::sin(phase), w3),
        accelerations(-turning * std::sin(phase), turning * std::cos(phase), 0);
    EXPECT_LT((three(s, "w{}") - rates).norm(), 300 * step * step);
    EXPECT_LT((three(s, "a{}") - accelerations).norm(), 3000 * step * step);
  }
}

/// A spherical pendulum that goes round on a cone: Ω² = g/(l cos θ), whatever its even inertia about the bob.
TEST_P(JointOutputs, APendulumOnACone) {
  const double angle = 0.6, length = 1.2, speed = std::sqrt(9.81 / (length * std::cos(angle)));
  Simulation s =
      simulation_of(of_ball(fmt::format("{{mass: 2, com: [{}, 0, {}], inertia: [0.05, 0.05, 0.05]}}",
                                        length * std::sin(angle), -length * std::cos(angle)),
                            fmt::format("[0, 0, {:.17g}]", speed), "[0, 0, -9.81]", 0.0005),
                    GetParam());
  for (const double end : {0.4, 1.0}) {
    run_to(s, end);
    const Eigen::Quaterniond exact(Eigen::AngleAxisd(speed * end, Eigen::Vector3d::UnitZ()));
    EXPECT_LT(turn_of(s).angularDistance(exact), 1e-5) << end;
    EXPECT_LT((three(s, "w{}") - Eigen::Vector3d(0, 0, speed)).norm(), 1e-4);
    EXPECT_LT(three(s, "a{}").norm(), 1e-3);
  }
}

/// θ̈ = −(m g l/I) sin θ at every instant, I about the hinge.
TEST_P(JointOutputs, AHinge) {
  Simulation s = simulation_of(R"y(
bodies: {bob: {mass: 2, com: [0, 0, -0.8], inertia: [0.1, 0.1, 0.1]}}
joints: {hinge: {type: revolute, between: [ground, bob], at: [0, 0, 0], axis: [0, 1, 0], position: 1.2}}
outputs: [{name: angle, joint: hinge}, {name: rise, joint_acceleration: hinge}]
simulation: {step: 0.002, end: 2}
)y",
                               GetParam());
  for (int k = 0; k < 8; ++k) {
    run_to(s, 0.2 * k);
    const double exact = -2 * 9.81 * 0.8 / (0.1 + 2 * 0.64) * std::sin(channel(s, "angle"));
    EXPECT_NEAR(channel(s, "rise"), exact, 1e-5) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(BothFormulations, JointOutputs,
                         testing::Values(Formulation::relative, Formulation::natural));

/// A floating joint to a body that another joint carries leaves nothing to hold: it transmits nothing, and
/// changes nothing.
TEST(FloatingJoints, BesideOthersTransmitNothing) {
  const auto text = [](const std::string& floating) {
    return R"(
bodies:
  a: {mass: 1, com: [0.3, 0, 0], inertia: [1, 1, 1]}
  b: {mass: 1, com: [1, 0.2, 0], inertia: [1, 1, 1]}
joints:
  j0: {type: revolute, between: [ground, a], at: [0, 0, 0], axis: [0, 1, 0]}
)" + floating +
           R"(  c: {type: revolute, between: [a, b], at: [0.5, 0, 0], axis: [0, 1, 0]}
outputs: [{name: turn, joint: c}]
)";
  };
  for (const Formulation formulation : {Formulation::relative, Formulation::natural})
    for (const std::string between : {"ground, b", "a, b", "b, ground"}) {
      Simulation with = simulation_of(
                     text("  free: {type: floating, between: [" + between + "], at: [1, 0, 0]}\n"),
                     formulation, 0.01),
                 without = simulation_of(text(""), formulation, 0.01);
      run_to(with, 0.2);
      run_to(without, 0.2);
      EXPECT_NEAR(channel(with, "turn"), channel(without, "turn"), 1e-9);
      for (const char* component : {"force.x", "force.y", "force.z", "moment.x", "moment.y", "moment.z"})
        EXPECT_EQ(channel(with, std::string("joint.free.") + component), 0) << component;
    }
}

}  // namespace
}  // namespace mimbre::test::joint_outputs_test
