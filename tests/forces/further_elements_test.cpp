#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "dynamics/natural/system.h"
#include "integrate/initial.h"
#include "support/models.h"
#include "support/probe.h"
#include "support/simulate.h"

/// Torsion springs, cables, motors and drag against what is known of them in closed form.
namespace mimbre::test::further_elements_test {
namespace {

constexpr double g = 9.81;

void step_to(Simulation& simulation, double time) {
  while (simulation.time() < time - 1e-9) ASSERT_TRUE(simulation.step().ok()) << simulation.time();
}

class FurtherElements : public testing::TestWithParam<Formulation> {};
INSTANTIATE_TEST_SUITE_P(BothFormulations, FurtherElements,
                         testing::Values(Formulation::relative, Formulation::natural));

/// Free fall over the slack, then half a swing about the static place: m g (s + e) = ½ k e².
TEST_P(FurtherElements, AMassFallsIntoItsCable) {
  const double mass = 2, slack = 0.4, length = 1.5, stiffness = 3e4, k = stiffness / length;
  Simulation s = simulation_of(fmt::format(R"y(
bodies: {{block: {{mass: {}, com: [0, 0, 0], inertia: [1, 1, 1]}}}}
joints: {{guide: {{type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [0, 0, -1]}}}}
cables: {{rope: {{over: [ground, block], at: [[0, 0, {}], [0, 0, 0]], axial_stiffness: {}, length: {}}}}}
outputs: [{{name: fallen, joint: guide}}]
)y",
                                           mass, length - slack, stiffness, length),
                               GetParam(), 2e-4);
  double most = 0;
  while (s.time() < 0.5) {
    ASSERT_TRUE(s.step().ok());
    const double fallen = channel(s, "fallen"), tension = -channel(s, "cable.rope.force");
    if (most == 0 && fallen < slack) {
      ASSERT_NEAR(fallen, 0.5 * g * s.time() * s.time(), 1e-9);
      ASSERT_EQ(tension, 0);
    } else {
      ASSERT_NEAR(tension, std::max(0.0, k * (fallen - slack)), 1e-9 * k);
      ASSERT_GE(tension, 0);
    }
    most = std::max(most, tension);
  }
  const double weight = mass * g;
  EXPECT_NEAR(most, weight + std::sqrt(weight * weight + 2 * k * weight * slack), 1e-3 * most);
  EXPECT_NEAR(s.energy().numerical, 0, 1e-3 * weight * slack);
}

/// Two masses on one cable over two points: a = (m₁ − m₂) g/(m₁ + m₂), T = 2 m₁ m₂ g/(m₁ + m₂).
TEST_P(FurtherElements, AtwoodsMachine) {
  const double m1 = 3, m2 = 2, tension = 2 * m1 * m2 * g / (m1 + m2), a = (m1 - m2) * g / (m1 + m2);
  for (const char* cut : {"never", "always"}) {
    Simulation s = simulation_of(fmt::format(R"y(
bodies:
  heavy: {{mass: {}, com: [0, 0, 0], inertia: [1, 1, 1]}}
  light: {{mass: {}, com: [1, 0, 0], inertia: [1, 1, 1]}}
joints:
  left: {{type: prismatic, between: [ground, heavy], at: [0, 0, 0], axis: [0, 0, -1], cut: {}}}
  right: {{type: prismatic, between: [ground, light], at: [1, 0, 0], axis: [0, 0, -1]}}
cables:
  rope: {{over: [heavy, ground, ground, light], at: [[0, 0, 0], [0, 0, 2], [1, 0, 2], [1, 0, 0]], axial_stiffness: 1e5, damping: 10, preload: {}}}
outputs: [{{name: z, position: heavy, component: z}}]
)y",
                                             m1, m2, cut, tension),
                                 GetParam(), 1e-3);
    step_to(s, 0.5);
    EXPECT_NEAR(channel(s, "z"), -0.5 * a * 0.25, 1e-7) << cut;
    EXPECT_NEAR(-channel(s, "cable.rope.force"), tension, 1e-6 * tension) << cut;
    EXPECT_NEAR(s.energy().numerical, 0, 1e-6) << cut;
  }
}

/// A hook that hangs in a cable between two points takes it symmetrically: T = m g/(2 cos of the half angle).
TEST_P(FurtherElements, AHookHangsInItsCable) {
  const double mass = 10;
  Simulation s = simulation_of(R"y(
initial: equilibrium
bodies: {hook: {mass: 10, com: [0, 0, -1], inertia: [0.1, 0.1, 0.1]}}
joints: {guide: {type: prismatic, between: [ground, hook], at: [0, 0, -1], axis: [0, 0, 1]}}
cables: {sling: {over: [ground, hook, ground], at: [[-1, 0, 0], [0, 0, -1], [1, 0, 0]], axial_stiffness: 1e6, length: 2.8}}
outputs: [{name: z, position: hook, component: z}]
)y",
                               GetParam(), 1e-3);
  const double length = channel(s, "cable.sling.measure"), tension = -channel(s, "cable.sling.force");
  const double depth = std::sqrt(0.25 * length * length - 1);
  EXPECT_NEAR(-channel(s, "z"), depth, 1e-12);
  EXPECT_NEAR(tension, 1e6 * (length - 2.8) / 2.8, 1e-8 * tension);
  EXPECT_NEAR(tension, mass * g * length / (4 * depth), 1e-6 * tension);
}

/// A winch pays out what it takes in as work.
TEST_P(FurtherElements, AWinchLifts) {
  Simulation s = simulation_of(R"y(
initial: equilibrium
bodies: {load: {mass: 50, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {guide: {type: prismatic, between: [ground, load], at: [0, 0, 0], axis: [0, 0, 1]}}
cables: {hoist: {over: [ground, load], at: [[0, 0, 3], [0, 0, 0]], axial_stiffness: 5e5, damping: 3000, length: "2.9 - 0.2*t*t"}}
outputs: [{name: z, joint: guide}]
)y",
                               GetParam(), 1e-3);
  const double start = channel(s, "z"), stretch = 50 * g * 2.9 / 5e5;
  EXPECT_NEAR(start, 0.1 - stretch, 1e-8);
  step_to(s, 1);
  EXPECT_NEAR(channel(s, "z"), 0.3, 3e-3);
  EXPECT_NEAR(s.energy().numerical, 0, 1e-3 * 50 * g * 0.2);
  EXPECT_NEAR(s.energy().load_work, 50 * g * (channel(s, "z") - start) + s.energy().kinetic, 0.5);
}

/// A load that goes up as fast as the winch reels in stays in balance: the damper has next to nothing to do,
/// neither over a step nor where one begins. That a model holds an input makes no difference.
TEST_P(FurtherElements, AWinchLiftsInBalance) {
  const double mass = 10, stiffness = 5e4, strain = mass * g / stiffness, length = 3 / (1 + strain);
  // But for what the part that is wound loses of its strain, which the damper takes.
  const double end = 0.25,
               height = 0.2 * end * (1 + strain) - 500 * 0.2 * strain * (length - 0.2 * end) / stiffness;
  const auto lifted = [&](const std::string& reeled, const std::string& inputs,
                          const std::string& integrator) {
    Simulation s = simulation_of(fmt::format(R"y(
{}bodies:
  load: {{mass: {}, com: [0, 0, 0], inertia: [1, 1, 1]}}
  drum: {{mass: 1, com: [0, 1, 0], inertia: [1, 1, 1]}}
joints:
  guide: {{type: prismatic, between: [ground, load], at: [0, 0, 0], axis: [0, 0, 1], velocity: 0.2}}
  drum: {{type: prismatic, between: [ground, drum], at: [0, 1, 0], axis: [1, 0, 0], drive: {{speed: 0.2}}}}
signals: {{wound: {{joint: drum}}}}
cables:
  hoist: {{over: [ground, load], at: [[0, 0, 3], [0, 0, 0]], axial_stiffness: {}, damping: 500, length: "{:.15f} - {}"}}
outputs: [{{name: z, joint: guide}}, {{name: a, acceleration: load, component: z}}]
simulation: {{integrator: {{type: {}}}, step: 1e-3, end: 1}}
)y",
                                             inputs, mass, stiffness, length, reeled, integrator),
                                 GetParam());
    // How fast the motion reels in is not known before the first step.
    if (reeled == "0.2*t") {
      EXPECT_NEAR(channel(s, "a"), 0, 1e-9) << integrator << inputs;
    }
    step_to(s, end);
    return channel(s, "z");
  };
  for (const char* inputs : {"", "inputs: {idle: 0}\n"}) {
    for (const char* integrator : {"generalized_alpha", "rk4", "dopri853", "radau",
                                   "dopri853, accuracy: 1e-8", "radau, accuracy: 1e-8"})
      EXPECT_NEAR(lifted("0.2*t", inputs, integrator), height, 1e-6) << integrator << inputs;
    for (const char* integrator : {"generalized_alpha", "rk4", "dopri853", "radau"})
      EXPECT_NEAR(lifted("wound", inputs, integrator), height, 1e-6) << integrator << inputs;
  }
}

/// From 0.3 m at 0.2 m/s: nothing is left after 1.5 s.
TEST_P(FurtherElements, AWinchBelowZeroIsSaid) {
  Simulation s = simulation_of(R"y(
bodies: {load: {mass: 50, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {guide: {type: prismatic, between: [ground, load], at: [0, 0, 0], axis: [0, 0, 1]}}
cables: {hoist: {over: [ground, load], at: [[0, 0, 0.301], [0, 0, 0]], axial_stiffness: 5e4, damping: 3000, length: "0.3 - 0.2*t"}}
)y",
                               GetParam(), 1e-3);
  step_to(s, 1.4);
  EXPECT_THAT(s.warnings(), testing::Not(testing::Contains(testing::HasSubstr("hoist"))));
  step_to(s, 1.51);
  EXPECT_THAT(s.warnings(),
              testing::Contains(testing::AllOf(testing::HasSubstr("cable 'hoist': its `length` is"),
                                               testing::HasSubstr("t = 1.4"))));
}

/// Two levers on springs c, joined by a bar k: a torque on the left one turns it by M (c + k)/(c (c + 2 k)).
TEST_P(FurtherElements, AnAntiRollBarJoinsTwoLevers) {
  for (const char* cut : {"never", "always"}) {
    Simulation s = simulation_of(fmt::format(R"y(
initial: equilibrium
gravity: [0, 0, 0]
bodies:
  left: {{mass: 1, com: [0, 0.5, 0], inertia: [0.1, 0.1, 0.1]}}
  right: {{mass: 1, com: [0, -0.5, 0], inertia: [0.1, 0.1, 0.1]}}
joints:
  a: {{type: revolute, between: [ground, left], at: [0, 0.5, 0], axis: [0, 1, 0], cut: {}, spring: {{stiffness: 300}}}}
  b: {{type: revolute, between: [ground, right], at: [0, -0.5, 0], axis: [0, 1, 0], spring: {{stiffness: 300}}}}
torsion_springs:
  bar: {{coordinates: [{{joint: a}}, {{joint: b, factor: -1}}], stiffness: 1200, damping: 5}}
loads: {{push: {{on: left, at: [0, 0.5, 0], moment: [0, 20, 0]}}}}
outputs: [{{name: a, joint: a}}, {{name: b, joint: b}}, {{name: my, joint_force: b, component: my}}]
)y",
                                             cut),
                                 GetParam(), 1e-3);
    const double c = 300, k = 1200, M = 20, left = M * (c + k) / (c * (c + 2 * k)),
                 right = M * k / (c * (c + 2 * k));
    EXPECT_NEAR(channel(s, "a"), left, 1e-8) << cut;
    EXPECT_NEAR(channel(s, "b"), right, 1e-8) << cut;
    EXPECT_NEAR(channel(s, "torsion_spring.bar.force"), -k * (left - right), 1e-6) << cut;
    EXPECT_NEAR(channel(s, "torsion_spring.bar.measure"), left - right, 1e-9) << cut;
    EXPECT_NEAR(s.energy().springs, 0.5 * (c * (left * left + right * right) + k * std::pow(left - right, 2)),
                1e-7);
  }
}

/// Active: at the moment M of a rest angle ρ the levers are at ±k ρ/(c + 2 k), and what turns the rest works.
/// Its laws by signals are the same force.
TEST_P(FurtherElements, AnAntiRollBarFollowsASignal) {
  const double c = 300, k = 1200, rho = 0.05;
  const auto bar = [&](const std::string& law, bool rests, const std::string& damping = "damping: 5") {
    return simulation_of(fmt::format(R"y(
{}gravity: [0, 0, 0]
bodies:
  left: {{mass: 1, com: [0, 0.5, 0], inertia: [0.1, 0.1, 0.1]}}
  right: {{mass: 1, com: [0, -0.5, 0], inertia: [0.1, 0.1, 0.1]}}
joints:
  a: {{type: revolute, between: [ground, left], at: [0, 0.5, 0], axis: [0, 1, 0], spring: {{stiffness: 300}}}}
  b: {{type: revolute, between: [ground, right], at: [0, -0.5, 0], axis: [0, 1, 0], cut: always, spring: {{stiffness: 300}}}}
inputs: {{tilt: 0.5}}
signals: {{lean: "0.1*tilt"}}
torsion_springs:
  bar: {{coordinates: [{{joint: a}}, {{joint: b, factor: -1}}], {}, {}}}
outputs: [{{name: a, joint: a}}, {{name: b, joint: b}}]
)y",
                                     rests ? "initial: equilibrium\n" : "", law, damping),
                         GetParam(), 2.5e-4);
  };
  for (const char* law : {"stiffness: 1200, rest: lean", "elastic: \"1200*(x - lean)\""}) {
    Simulation still = bar(law, true);
    EXPECT_NEAR(channel(still, "a"), k * rho / (c + 2 * k), 1e-8) << law;
    EXPECT_NEAR(channel(still, "b"), -k * rho / (c + 2 * k), 1e-8) << law;
    EXPECT_NEAR(channel(still, "torsion_spring.bar.force"), k * rho * c / (c + 2 * k), 1e-6) << law;
    still.set_input(still.input("tilt"), 0);
    step_to(still, 1);
    EXPECT_NEAR(channel(still, "a"), 0, 1e-6) << law;
  }
  // One mode swings: (J s̈ + (c + 2 k) s + 2 d ṡ = 2 k ρ) of s = a − b, from rest.
  const double J = 0.1, d = 5, w = std::sqrt((c + 2 * k) / J), zeta = 2 * d / (2 * J * w),
               wd = w * std::sqrt(1 - zeta * zeta);
  for (const auto& [law, damping] :
       {std::pair("stiffness: 1200, rest: lean", "damping: 5"),
        std::pair("elastic: \"1200*(x - lean)\"", "damping: \"10*v*tilt\""),
        std::pair("stiffness: 1200, rest: \"lean + 0*t\"", "damping: \"10*v*tilt\"")}) {
    Simulation s = bar(law, false, damping);
    for (const double time : {0.004, 0.01, 0.03}) {
      step_to(s, time);
      const double swing =
          1 - std::exp(-zeta * w * time) * (std::cos(wd * time) + zeta * w / wd * std::sin(wd * time));
      EXPECT_NEAR(channel(s, "a") - channel(s, "b"), 2 * k * rho / (c + 2 * k) * swing, 4e-4 * rho)
          << law << ", " << damping << " at " << time;
    }
    EXPECT_NEAR(s.energy().numerical, 0, 1e-3 * k * rho * rho) << law;
  }
}

/// A falling body: v = v∞ tanh(g t/v∞), v∞ = √(2 m g/(ρ c A)).
TEST_P(FurtherElements, DragHasItsTerminalVelocity) {
  const double mass = 3, area = 0.5, c = 1.2, density = 1.1;
  Simulation s = simulation_of(fmt::format(R"y(
bodies: {{ball: {{mass: {}, com: [0, 0, 0], inertia: [0.1, 0.1, 0.1]}}}}
joints: {{free: {{type: floating, between: [ground, ball], at: [0, 0, 0]}}}}
drags: {{air: {{on: ball, area: {}, density: {}, coefficients: {}}}}}
outputs: [{{name: v, velocity: ball, component: z}}]
)y",
                                           mass, area, density, c),
                               GetParam(), 1e-3);
  const double end = std::sqrt(2 * mass * g / (density * c * area));
  for (const double time : {0.2, 0.6, 1.0, 3.0}) {
    step_to(s, time);
    EXPECT_NEAR(-channel(s, "v"), end * std::tanh(g * time / end), 1e-5 * end) << time;
  }
  EXPECT_NEAR(channel(s, "drag.air.force.z"), mass * g * std::pow(std::tanh(g * s.time() / end), 2), 1e-3);
  EXPECT_NEAR(s.energy().numerical, 0, 1e-4);
}

/// By the axes of the frame, against a wind: the force of a turned plate by hand.
TEST_P(FurtherElements, DragKnowsItsAxesAndTheWind) {
  Simulation run = simulation_of(R"y(
bodies: {plate: {mass: 3, com: [0, 0, 0], inertia: [0.1, 0.1, 0.1]}}
joints: {guide: {type: prismatic, between: [ground, plate], at: [0, 0, 0], axis: [0, 0, 1], velocity: [2]}}
drags: {air: {on: plate, x: [0.6, 0, 0.8], z: [-0.8, 0, 0.6], area: 0.5, density: 1.1, coefficients: [0.3, 0.5, 2], wind: [7, -3, "1 + 0*t"]}}
)y",
                                 GetParam(), 1e-3);
  const Eigen::Vector3d u(-7, 3, 1), x(0.6, 0, 0.8), y(0, 1, 0), z(-0.8, 0, 0.6);
  const double factor = -0.5 * 1.1 * 0.5 * u.norm();
  EXPECT_NEAR(channel(run, "drag.air.force.x"), factor * 0.3 * u.dot(x), 1e-9);
  EXPECT_NEAR(channel(run, "drag.air.force.y"), factor * 0.5 * u.dot(y), 1e-9);
  EXPECT_NEAR(channel(run, "drag.air.force.z"), factor * 2 * u.dot(z), 1e-9);
  step_to(run, 0.5);
  EXPECT_NEAR(run.energy().numerical, 0, 1e-4);
}

/// Of a DC motor with a gear: ω = ω₀ (1 − e^(−t/τ)), ω₀ = U/(n K), τ = (J + n² J_m) R/(n K)².
TEST_P(FurtherElements, ADcMotorRunsUp) {
  const double U = 24, K = 0.05, R = 0.8, n = 20, J = 0.3, rotor = 2e-4;
  const double free = U / (n * K), constant = (J + n * n * rotor) * R / (n * K * n * K);
  for (const char* cut : {"never", "always"}) {
    Simulation s = simulation_of(fmt::format(R"y(
gravity: [0, 0, 0]
bodies: {{wheel: {{mass: 1, com: [0, 0, 0], inertia: [1, 1, {}]}}}}
joints: {{axle: {{type: revolute, between: [ground, wheel], at: [0, 0, 0], axis: [0, 0, 1], cut: {}}}}}
motors: {{drive: {{joint: axle, constant: {}, resistance: {}, ratio: {}, inertia: {}, voltage: {}}}}}
outputs: [{{name: speed, joint_velocity: axle}}]
)y",
                                             J, cut, K, R, n, rotor, U),
                                 GetParam(), 2e-4);
    // The torque at rest without what its own rotor takes of it.
    EXPECT_NEAR(channel(s, "motor.drive.force"), n * K * U / R * J / (J + n * n * rotor), 1e-6) << cut;
    for (const double share : {0.3, 1.0, 3.0, 8.0}) {
      step_to(s, share * constant);
      const double time = s.time();
      EXPECT_NEAR(channel(s, "speed"), free * (1 - std::exp(-time / constant)), 2e-5 * free) << cut << share;
    }
    EXPECT_NEAR(s.energy().kinetic, 0.5 * (J + n * n * rotor) * std::pow(channel(s, "speed"), 2), 1e-6);
    EXPECT_NEAR(s.energy().numerical, 0, 1e-4 * s.energy().kinetic);
  }
}

/// By a curve: a straight one is that of a DC motor; half the command has half of it; losses of drag and
/// gear.
TEST_P(FurtherElements, AMotorFollowsItsCurve) {
  const double stall = 2, free = 150, n = 10, J = 4;
  const auto run = [&](const std::string& more, double time) {
    Simulation s = simulation_of(fmt::format(R"y(
gravity: [0, 0, 0]
bodies: {{wheel: {{mass: 1, com: [0, 0, 0], inertia: [4, 4, {}]}}}}
joints: {{axle: {{type: revolute, between: [ground, wheel], at: [0, 0, 0], axis: [0, 0, 1]}}}}
motors: {{drive: {{joint: axle, curve: {{table: [[0, {}], [{}, 0]]}}, ratio: {}, {}}}}}
outputs: [{{name: speed, joint_velocity: axle}}]
)y",
                                             J, stall, free, n, more),
                                 GetParam(), 1e-3);
    step_to(s, time);
    EXPECT_NEAR(s.energy().numerical, 0, 1e-4 * s.energy().kinetic + 1e-9);
    return channel(s, "speed");
  };
  const double most = free / n, constant = J / (n * n * stall / free);
  EXPECT_NEAR(run("command: 1", 2), most * (1 - std::exp(-2 / constant)), 1e-5 * most);
  EXPECT_NEAR(run("command: -1", 2), -most * (1 - std::exp(-2 / constant)), 1e-5 * most);
  EXPECT_NEAR(run("command: 0.5", 2), most * (1 - std::exp(-1 / constant)), 1e-5 * most);
  // Where drag takes all: stall (1 − ω/ω₀) = d ω.
  const double drag = 0.01, end = stall / (stall / free + drag) / n;
  EXPECT_NEAR(run("command: 1, drag: 0.01", 20), end, 1e-4 * end);
  // A constant torque by its limit, of which the gear leaves a part: t long enough that the start counts
  // little.
  const double slow = run("command: 1, torque_limit: 0.1, efficiency: 0.8", 4),
               fast = run("command: 1, torque_limit: 0.1", 4);
  EXPECT_NEAR(fast, n * 0.1 * 4 / J, 1e-6);
  EXPECT_NEAR(slow, 0.8 * fast, 0.05 * fast);
}

/// The rotor's inertia weighs as the square of its ratio.
TEST_P(FurtherElements, GearedInertiaIsTrueInertia) {
  for (const char* cut : {"never", "always"}) {
    Simulation s = simulation_of(fmt::format(R"y(
gravity: [0, 0, 0]
bodies: {{wheel: {{mass: 1, com: [0, 0, 0], inertia: [1, 1, 0.5]}}}}
joints: {{axle: {{type: revolute, between: [ground, wheel], at: [0, 0, 0], axis: [0, 0, 1], cut: {}}}}}
motors: {{idle: {{joint: axle, curve: {{table: [[0, 1], [1, 1]]}}, command: 0, ratio: -30, inertia: 1e-3}}}}
loads: {{push: {{on: wheel, moment: [0, 0, 7]}}}}
outputs: [{{name: speed, joint_velocity: axle}}]
)y",
                                             cut),
                                 GetParam(), 1e-3);
    step_to(s, 1);
    EXPECT_NEAR(channel(s, "speed"), 7 / (0.5 + 900 * 1e-3), 1e-4) << cut;
    EXPECT_NEAR(channel(s, "motor.idle.force"), -7 * 0.9 / 1.4, 1e-5) << cut;
  }
}

/// A four-bar whose elements have symmetric tangents that nothing else adds to.
std::shared_ptr<const Model> plain_four_bar() {
  spec::Model model = geared_four_bar()->spec();
  for (spec::Element& e : model.elements) {
    if (e.law == "motor") e.arguments = {{spec::Source::Kind::input, 0}};
    // A curve has a kink at rest.
    if (e.law == "motor" && !e.functions.empty()) e.functions = {Function::constant(0.05)};
    if (e.law == "drag") e.numbers[2] = e.numbers[3] = e.numbers[4] = 0.8;
  }
  return Model::compile(std::move(model));
}

/// At rest, where the velocity-dependent forces of inertia have no derivative: M and C of the elements that
/// act on several bodies, or have inertia, are the derivatives of the residual.
TEST(ElementsOverSeveralBodies, HaveTheirMassAndDampingInTheMatrix) {
  const std::shared_ptr<const Model> model = plain_four_bar();
  Probe p(model->compiled());
  natural::NaturalSystem natural(p.m);
  Random random(3);
  VectorXd q = VectorXd::Zero(p.m.positions);
  q = p.moved(q, random.values(p.n, 0.2));
  const auto expect = [&](int n, const auto& residual, const auto& matrix) {
    const VectorXd rest = VectorXd::Zero(n);
    const MatrixXd mass = matrix(MatrixWeights{0, 0, 0}), damping = matrix(MatrixWeights{1, 0, 0}) - mass;
    const VectorXd r = residual(rest, rest);
    MatrixXd by_a(n, n), by_v(n, n);
    for (int k = 0; k < n; ++k) {
      const double h = 1e-5;
      by_a.col(k) = residual(rest, VectorXd::Unit(n, k)) - r;
      by_v.col(k) =
          (residual(h * VectorXd::Unit(n, k), rest) - residual(-h * VectorXd::Unit(n, k), rest)) / (2 * h);
    }
    EXPECT_LT(relative_difference(by_a, mass), 1e-10);
    EXPECT_LT(relative_difference(by_v, damping, 1e-3), 1e-6);
    EXPECT_GT(damping.norm(), 1e-2);
  };
  expect(
      p.n, [&](const VectorXd& v, const VectorXd& a) { return p.residual(q, v, a); },
      [&](const MatrixWeights& weights) { return p.matrix(q, p.zero, weights); });
  p.kinematics(q, p.zero, p.zero);
  State s;
  s.q = q;
  s.v = s.a = s.algorithmic = p.zero;
  s.multipliers = VectorXd::Zero(p.equations);
  const State start = natural.from_relative(s, p.system.workspace().bodies, p.system.workspace().origin);
  const VectorXd none = VectorXd::Zero(natural.equations());
  const int n = natural.velocities();
  expect(
      n,
      [&](const VectorXd& v, const VectorXd& a) {
        VectorXd r(n);
        natural.residual(0, start.q.data(), v.data(), a.data(), none.data(), 0, r.data());
        return r;
      },
      [&](const MatrixWeights& weights) {
        const VectorXd rest = VectorXd::Zero(n);
        VectorXd r(n);
        natural.residual(0, start.q.data(), rest.data(), rest.data(), none.data(), 0, r.data());
        MatrixXd matrix(n, n);
        natural.dense_matrix(start.q.data(), weights, matrix.data());
        return matrix;
      });
}

/// The same motion and the same forces in both formulations.
TEST(ElementsOverSeveralBodies, MoveAlikeInBothFormulations) {
  const auto course = [](Formulation formulation) {
    Simulation s = simulation_of(geared_four_bar(), formulation, 2e-4);
    std::vector<double> all;
    for (int k = 0; k < 1000; ++k) {
      EXPECT_TRUE(s.step().ok());
      if (k % 100 == 0)
        for (const char* name :
             {"joint.crank.position", "joint.rocker.position", "torsion_spring.bar.force",
              "cable.hoist.force", "motor.dc.force", "motor.curve.force", "drag.sail.force.z"})
          all.push_back(channel(s, name));
    }
    EXPECT_NEAR(s.energy().numerical, 0, 1e-4);
    return all;
  };
  const std::vector<double> a = course(Formulation::relative), b = course(Formulation::natural);
  for (std::size_t k = 0; k < a.size(); ++k) EXPECT_NEAR(a[k], b[k], 1e-4 * (1 + std::abs(a[k]))) << k;
}

}  // namespace
}  // namespace mimbre::test::further_elements_test
