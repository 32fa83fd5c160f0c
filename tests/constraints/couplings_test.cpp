#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mimbre/model_builder.h"
#include "mimbre/simulation.h"
#include "mimbre/statics.h"
#include "support/models.h"
#include "support/simulate.h"

/// Couplings of joint coordinates: gears, racks, screws, differentials.
namespace mimbre::test::couplings_test {
namespace {

using std::numbers::pi;
using testing::ElementsAre;
using testing::HasSubstr;
using Formalism = spec::Simulation::Formalism;

class Couplings : public testing::TestWithParam<Formulation> {
 protected:
  RunOptions options() const {
    RunOptions o;
    o.formulation = GetParam();
    o.tolerance = 1e-9;
    o.step = natural() ? 0.001 : 0.005;
    o.integrator = spec::Simulation::Integrator::newmark;
    o.xi = 0;
    return o;
  }
  bool natural() const { return GetParam() == Formulation::natural; }
  /// Steady accelerations are exact in joint coordinates; unit vectors turn by steps of second order.
  void expect_near(double value, double expected, double exact) const {
    EXPECT_NEAR(value, expected, natural() ? 2e-3 * std::abs(expected) + 1e-6 : exact);
  }
};
INSTANTIATE_TEST_SUITE_P(Formulations, Couplings,
                         testing::Values(Formulation::relative, Formulation::natural), [](const auto& of) {
                           return of.param == Formulation::natural ? "natural" : "relative";
                         });

/// Three shafts in the ground along x, coupled by two pairs of wheels: 17 : 51 outside, 60 : 20 inside; a
/// torque on the first. `cut`: of the last shaft's joint, whose wheel then floats.
std::string train(const std::string& more = "") {
  return fmt::format(R"(
gravity: [0, 0, 0]
bodies:
  one: {{mass: 1, com: [0, 0, 0], inertia: [0.002, 0.01, 0.01]}}
  two: {{mass: 2, com: [0, 0.3, 0], inertia: [0.05, 0.1, 0.1]}}
  three: {{mass: 1, com: [0, 0.6, 0], inertia: [0.007, 0.01, 0.01]}}
joints:
  one: {{type: revolute, between: [ground, one], at: [0, 0, 0], axis: [1, 0, 0]}}
  two: {{type: revolute, between: [ground, two], at: [0, 0.3, 0], axis: [1, 0, 0]}}
  three: {{type: revolute, between: [ground, three], at: [0, 0.6, 0], axis: [1, 0, 0]}}
constraints:
  first: {{type: gear, joints: [one, two], teeth: [17, 51]}}
  second: {{type: gear, joints: [two, three], teeth: [60, 20], internal: true}}
{}
actuators: {{motor: {{joint: one, torque: 0.5}}}}
)",
                     more);
}

/// By hand: ω2 = −ω1/3, ω3 = 3 ω2 = −ω1. The motor's torque T accelerates J1 + J2/9 + J3. The first mesh
/// loads shaft one with −(J2/9 + J3) α1 and shaft two with three times that, backwards.
TEST_P(Couplings, AGearTrainHasItsRatiosAndTorques) {
  Simulation s(model_of(train()), options());
  run_to(s, 1);
  const double J = 0.002 + 0.05 / 9 + 0.007, alpha = 0.5 / J;
  expect_near(channel(s, "joint.one.velocity"), alpha, 1e-6 * alpha);
  expect_near(channel(s, "joint.one.position"), alpha / 2, 1e-6 * alpha);
  expect_near(channel(s, "joint.two.position"), -alpha / 6, 1e-6 * alpha);
  expect_near(channel(s, "joint.three.position"), -alpha / 2, 1e-6 * alpha);
  const double mesh = (0.05 / 9 + 0.007) * alpha;
  expect_near(channel(s, "constraint.first.force.one"), -mesh, 1e-6);
  expect_near(channel(s, "constraint.first.force.two"), -3 * mesh, 1e-6);
  expect_near(channel(s, "constraint.second.force.three"), -0.007 * alpha, 1e-6);
  expect_near(channel(s, "constraint.second.force.two"), 0.007 * 3 * alpha, 1e-6);
  EXPECT_EQ(s.degrees_of_freedom(), 1);
}

/// All that acts on a gear does no work: energy is the motor's work.
TEST_P(Couplings, DoNoWork) {
  Simulation s(model_of(train()), options());
  run_to(s, 1);
  expect_near(channel(s, "energy.kinetic"), 0.5 * channel(s, "joint.one.position"), 1e-6);
  EXPECT_NEAR(channel(s, "energy.numerical"), 0, natural() ? 0.02 : 1e-6);
}

/// A pinion on the ground drives a rack upwards against its weight; from the equilibrium's torque and from
/// rest.
TEST_P(Couplings, ARackMovesByThePinionsRadius) {
  Simulation s(model_of(R"(
bodies:
  pinion: {mass: 0.5, com: [0, 0, 0], inertia: [1e-3, 1e-3, 1e-3]}
  rack: {mass: 3, com: [0, 0.02, 0], inertia: [1e-2, 1e-2, 1e-2]}
joints:
  pinion: {type: revolute, between: [ground, pinion], at: [0, 0, 0], axis: [1, 0, 0]}
  rack: {type: prismatic, between: [ground, rack], at: [0, 0.02, 0], axis: [0, 0, 1]}
constraints: {mesh: {type: rack, joints: [pinion, rack], radius: 20 mm}}
actuators: {motor: {joint: pinion, torque: 1}}
)"),
               options());
  run_to(s, 0.5);
  // (J/r² + m) z̈ = T/r − m g
  const double r = 0.02, g = 9.81, second = (1 / r - 3 * g) / (1e-3 / (r * r) + 3);
  expect_near(channel(s, "joint.rack.position"), second / 8, 1e-8);
  expect_near(channel(s, "joint.pinion.position"), second / 8 / r, 1e-6);
  expect_near(channel(s, "constraint.mesh.force.rack"), 3 * (g + second), 1e-6);
  expect_near(channel(s, "constraint.mesh.force.pinion"), -r * 3 * (g + second), 1e-7);
}

/// A nut on a spindle falls, and turns as it does: m z̈ = −m g − F, J φ̈ = F p with z = p φ.
TEST_P(Couplings, AScrewTurnsWhatFalls) {
  for (const double lead : {0.05, -0.2}) {
    Simulation s(model_of(fmt::format(R"(
bodies: {{nut: {{mass: 2, com: [0.1, 0, 0], inertia: [0.003, 0.003, 0.005]}}}}
constraints: {{thread: {{type: screw, between: [ground, nut], at: [0.1, 0, 0], axis: [0, 0, 1], lead: {}}}}}
outputs:
  - {{name: z, position: nut, component: z}}
  - {{name: spin, angular_velocity: nut, component: z}}
)",
                                      lead)),
                 options());
    EXPECT_EQ(s.degrees_of_freedom(), 1);
    run_to(s, 1);
    const double p = lead / (2 * pi), second = -9.81 * 2 / (2 + 0.005 / (p * p));
    expect_near(channel(s, "z"), second / 2, 1e-7);
    expect_near(channel(s, "spin"), second / p, 1e-5);
    expect_near(channel(s, "constraint.thread.force.z"), 2 * (9.81 + second), 1e-6);
    expect_near(channel(s, "constraint.thread.moment.z"), 0.005 * second / p, 1e-6);
  }
}

/// The same by a cylindrical joint whose coordinates are coupled, in the tree and cut: many turns.
TEST_P(Couplings, OfACylindricalJointAreAScrew) {
  for (const char* cut : {"never", "always"}) {
    Simulation s(model_of(fmt::format(R"(
bodies: {{nut: {{mass: 2, com: [0.1, 0, 0], inertia: [0.003, 0.003, 0.005]}}}}
joints: {{spindle: {{type: cylindrical, between: [ground, nut], at: [0.1, 0, 0], axis: [0, 0, 1], cut: {}}}}}
constraints:
  thread:
    type: coupling
    terms: [{{joint: spindle, coordinate: 1, factor: 1}}, {{joint: spindle, coordinate: 0, factor: -0.05/(2*pi)}}]
outputs: [{{name: z, position: nut, component: z}}]
)",
                                      cut)),
                 options());
    run_to(s, 1.5);
    const double p = 0.05 / (2 * pi), second = -9.81 * 2 / (2 + 0.005 / (p * p));
    EXPECT_LT(second * 1.125 / p, -10 * pi) << "turns often";
    expect_near(channel(s, "z"), second * 1.125, 1e-7);
    expect_near(channel(s, "constraint.thread.force.spindle.1"), 2 * (9.81 + second), 1e-6);
    expect_near(channel(s, "constraint.thread.force.spindle.0"), 0.005 * second / p, 1e-6);
  }
}

/// A differential: the cage's torque is shared evenly whatever the speeds, and the cage has their mean.
TEST_P(Couplings, ADifferentialSharesItsTorqueEvenly) {
  Simulation s(model_of(R"(
gravity: [0, 0, 0]
bodies:
  cage: {mass: 1, com: [0, 0, 0], inertia: [0.004, 0.004, 0.004]}
  left: {mass: 1, com: [0, 0.5, 0], inertia: [0.02, 0.01, 0.02]}
  right: {mass: 1, com: [0, -0.5, 0], inertia: [0.02, 0.03, 0.02]}
joints:
  cage: {type: revolute, between: [ground, cage], at: [0, 0, 0], axis: [0, 1, 0]}
  left: {type: revolute, between: [ground, left], at: [0, 0.5, 0], axis: [0, 1, 0]}
  right: {type: revolute, between: [ground, right], at: [0, -0.5, 0], axis: [0, 1, 0]}
constraints: {differential: {type: differential, joints: [cage, left, right]}}
actuators: {motor: {joint: cage, torque: 2}}
)"),
               options());
  run_to(s, 1);
  const double left = channel(s, "joint.left.velocity"), right = channel(s, "joint.right.velocity");
  expect_near(channel(s, "joint.cage.velocity"), (left + right) / 2, 1e-9);
  expect_near(left * 0.01, right * 0.03, 1e-7);
  expect_near(channel(s, "constraint.differential.force.left"),
              channel(s, "constraint.differential.force.right"), 1e-9);
  // 2 T = …: (J_cage + 4 /(1/J_l + 1/J_r)) α = T
  const double alpha = 2 / (0.004 + 4 / (1 / 0.01 + 1 / 0.03));
  expect_near(channel(s, "joint.cage.velocity"), alpha, 1e-6 * alpha);
}

/// A planetary gear set, its wheels carried by the arm: joints relative to the arm have fixed ratios.
/// Willis: (ω_sun − ω_arm)/(ω_ring − ω_arm) = −z_ring/z_sun.
TEST_P(Couplings, APlanetaryGearKeepsWillisEquation) {
  Simulation s(model_of(R"yaml(
gravity: [0, 0, 0]
bodies:
  arm: {mass: 1, com: [0, 0, 0], inertia: [0.01, 0.01, 0.02]}
  sun: {mass: 1, com: [0, 0, 0], inertia: [0.001, 0.001, 0.002]}
  planet: {mass: 0.3, com: [0.06, 0, 0], inertia: [1e-4, 1e-4, 2e-4]}
  ring: {mass: 2, com: [0, 0, 0], inertia: [0.02, 0.02, 0.04]}
joints:
  arm: {type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 0, 1]}
  sun: {type: revolute, between: [arm, sun], at: [0, 0, 0], axis: [0, 0, 1]}
  planet: {type: revolute, between: [arm, planet], at: [0.06, 0, 0], axis: [0, 0, 1]}
  ring: {type: revolute, between: [arm, ring], at: [0, 0, 0], axis: [0, 0, 1]}
constraints:
  inside: {type: gear, joints: [sun, planet], teeth: [24, 18]}
  outside: {type: gear, joints: [planet, ring], teeth: [18, 60], internal: true}
loads:
  motor: {on: sun, moment: [0, 0, 0.3]}
  brake: {on: ring, moment: [0, 0, -0.1], scale: "sin(7*t)"}
outputs:
  - {name: arm, angular_velocity: arm, component: z}
  - {name: sun, angular_velocity: sun, component: z}
  - {name: ring, angular_velocity: ring, component: z}
)yaml"),
               options());
  run_to(s, 1.3);
  EXPECT_GT(std::abs(channel(s, "ring")), 0.1);
  EXPECT_NEAR((channel(s, "sun") - channel(s, "arm")) / (channel(s, "ring") - channel(s, "arm")), -60.0 / 24,
              1e-8);
}

/// Whatever the method.
TEST_P(Couplings, HoldByEveryFormalism) {
  const double J = 0.002 + 0.05 / 9 + 0.007, alpha = 0.5 / J;
  for (const Formalism formalism :
       {Formalism::index3, Formalism::index1, Formalism::baumgarte, Formalism::penalty,
        Formalism::index1_augmented, Formalism::independent}) {
    RunOptions o = options();
    o.formalism = formalism;
    o.tolerance.reset();
    Simulation s(model_of(train()), o);
    run_to(s, 0.5);
    expect_near(channel(s, "joint.one.velocity"), alpha / 2, 1e-3 * alpha);
    expect_near(channel(s, "joint.three.position"), -alpha / 8, 1e-3 * alpha);
  }
  RunOptions conserving = options();
  conserving.integrator = spec::Simulation::Integrator::conserve;
  conserving.xi.reset();  // which belongs to Newmark's rule
  Simulation s(model_of(train()), conserving);
  run_to(s, 0.5);
  expect_near(channel(s, "joint.one.velocity"), alpha / 2, 1e-6 * alpha);
}

/// Two gears that say the same share what they bear, and the check names them.
TEST_P(Couplings, ThatAreEqualAreRedundant) {
  const std::string twice = "  again: {type: gear, joints: [one, two], ratio: -3}";
  Simulation s(model_of(train(twice)), options());
  EXPECT_EQ(s.degrees_of_freedom(), 1);
  EXPECT_EQ(s.redundancy().equations, 1);
  EXPECT_THAT(s.redundancy().joints, testing::IsEmpty());
  EXPECT_THAT(s.redundancy().constraints, ElementsAre("first", "again"));
  run_to(s, 1);
  const double J = 0.002 + 0.05 / 9 + 0.007, alpha = 0.5 / J;
  expect_near(channel(s, "joint.one.velocity"), alpha, 1e-5 * alpha);
  expect_near(channel(s, "constraint.first.force.one") + channel(s, "constraint.again.force.one"),
              -(0.05 / 9 + 0.007) * alpha, 1e-5);
}

TEST(CouplingsThatContradict, AreNamed) {
  const auto model = model_of(train("  off: {type: gear, joints: [one, two], ratio: -3, constant: 0.1}"));
  try {
    Simulation s(model);
    FAIL() << "has started";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("cannot be fulfilled: "));
    EXPECT_THAT(error.what(), AnyOf(HasSubstr("constraint 'first'"), HasSubstr("constraint 'off'")));
    EXPECT_THAT(error.what(), HasSubstr(" rad is left"));
  }
}

/// Two ratios at once leave no motion, but contradict nothing.
TEST_P(Couplings, OfTwoRatiosLock) {
  Simulation s(model_of(train("  other: {type: gear, joints: [one, two], ratio: 2}")), options());
  EXPECT_EQ(s.degrees_of_freedom(), 0);
  run_to(s, 0.2);
  EXPECT_NEAR(channel(s, "joint.one.position"), 0, 1e-12);
}

/// Initial values go through them.
TEST_P(Couplings, FindTheInitialValuesOfOthers) {
  std::string text = train();
  const std::string one = "at: [0, 0, 0], axis: [1, 0, 0]";
  text.replace(text.find(one), one.size(), one + ", position: 0.3, velocity: 6");
  Simulation s(model_of(text), options());
  EXPECT_NEAR(channel(s, "joint.two.position"), -0.1, 1e-12);
  EXPECT_NEAR(channel(s, "joint.three.velocity"), -6, 1e-12);
}

/// The force on a lever with a weight is found at rest.
TEST_P(Couplings, HoldAtRest) {
  const auto model = model_of(R"(
bodies:
  lever: {mass: 2, com: [0.5, 0, 0], inertia: [0.1, 0.1, 0.1]}
  drum: {mass: 1, com: [0, 0, 1], inertia: [0.01, 0.01, 0.01]}
joints:
  lever: {type: revolute, between: [ground, lever], at: [0, 0, 0], axis: [0, 1, 0]}
  drum: {type: revolute, between: [ground, drum], at: [0, 0, 1], axis: [0, 1, 0], spring: {stiffness: 3}}
constraints: {chain: {type: gear, joints: [lever, drum], ratio: 0.5}}
initial: equilibrium
)");
  Simulation s(model, options());
  // m g ½ cos θ = 2 · 3 · 2 θ, down by θ about y.
  const double theta = channel(s, "joint.lever.position");
  EXPECT_NEAR(2 * 9.81 * 0.5 * std::cos(theta), 12 * theta, 1e-6);
  EXPECT_NEAR(channel(s, "joint.drum.position"), 2 * theta, 1e-10);
}

/// Angles count their turns, also in a state that is kept: after a hundred turns of a cut joint.
TEST_P(Couplings, RememberTurnsInTheState) {
  std::string text = train();
  const std::string three = "at: [0, 0.6, 0], axis: [1, 0, 0]";
  text.replace(text.find(three), three.size(), three + ", cut: always");
  Simulation s(model_of(text), options());
  run_to(s, 5);
  EXPECT_GT(std::abs(channel(s, "joint.one.position")), 100 * pi);
  const Simulation::Snapshot saved = s.save();
  Simulation other(model_of(text), options());
  other.restore(Simulation::Snapshot::from_bytes(saved.bytes()));
  for (int k = 0; k < 20; ++k) {
    ASSERT_TRUE(s.step().ok());
    ASSERT_TRUE(other.step().ok());
  }
  EXPECT_EQ(channel(s, "joint.one.position"), channel(other, "joint.one.position"));
  EXPECT_EQ(channel(s, "constraint.first.force.one"), channel(other, "constraint.first.force.one"));
}

/// Turns that initial values give count: by the nut's joint, by two joints in a row, or by how far it has
/// come.
TEST_P(Couplings, AScrewStartsAsManyTurnsOnAsItIsGiven) {
  const auto start = [&](const std::string& joints, const std::string& nut) {
    Simulation s(model_of(fmt::format(R"(
gravity: [0, 0, 0]
bodies:
  ring: {{mass: 1, com: [0, 0, 0], inertia: [0.01, 0.01, 0.01]}}
  nut: {{mass: 1, com: [0, 0, 0], inertia: [0.01, 0.01, 0.01]}}
joints:
  {}
constraints:
  thread: {{type: screw, between: [ground, nut], at: [0, 0, 0], axis: [0, 0, 1], lead: 0.5}}
outputs:
  - {{name: z, position: nut, component: z}}
  - {{name: turn, joint: {}, component: 0}}
)",
                                      joints, nut)),
                 options());
    EXPECT_TRUE(s.warnings().empty() || s.warnings().front().find("turns") != std::string::npos)
        << s.warnings().front();
    return std::pair(channel(s, "z"), channel(s, "turn"));
  };
  const auto one = [&](const std::string& given) {
    return start(
        "ring: {type: fixed, between: [ground, ring], at: [0, 0, 0]}\n"
        "  nut: {type: cylindrical, between: [ground, nut], at: [0, 0, 0], axis: [0, 0, 1], " +
            given + "}",
        "nut");
  };
  for (const double turn : {1.0, 4.0, -4.0, 20.0}) {
    const auto [z, at] = one(fmt::format("position: [{}, null]", turn));
    EXPECT_NEAR(z, 0.5 * turn / (2 * pi), 1e-12) << turn;
    EXPECT_NEAR(at, turn, 1e-12);
  }
  for (const double z : {0.2, 1.6, -3.3}) {
    const auto [at, turn] = one(fmt::format("position: [null, {}]", z));
    EXPECT_NEAR(at, z, 1e-12);
    EXPECT_NEAR(turn, 4 * pi * z, 1e-9);
  }
  EXPECT_NEAR(one("position: [4, 0.31830988618379067]").first, 1 / pi, 1e-12);
  const auto [z, at] = start(
      "ring: {type: revolute, between: [ground, ring], at: [0, 0, 0], axis: [0, 0, 1], position: 2}\n"
      "  nut: {type: cylindrical, between: [ring, nut], at: [0, 0, 0], axis: [0, 0, 1], position: [3, null]}",
      "nut");
  EXPECT_NEAR(z, 0.5 * 5 / (2 * pi), 1e-12);
  EXPECT_NEAR(at, 3, 1e-12);
}

/// The builder says the same as a file.
TEST_P(Couplings, AreBuiltInCode) {
  ModelBuilder m("train");
  m.set_gravity({0, 0, 0});
  const double inertia[] = {0.002, 0.05, 0.007};
  const char* names[] = {"one", "two", "three"};
  for (int k = 0; k < 3; ++k) {
    m.add_body(names[k],
               {.mass = 1, .com = {0, 0.3 * k, 0}, .inertia = build::inertia(inertia[k], 0.1, 0.1)});
    m.add_joint(names[k], {.type = spec::JointType::revolute,
                           .between = {"ground", names[k]},
                           .at = Eigen::Vector3d{0, 0.3 * k, 0},
                           .axis = Eigen::Vector3d{1, 0, 0}});
  }
  m.add_constraint("first", build::gear("one", "two", -3));
  m.add_constraint("second", build::gear("two", "three", 1.0 / 3));
  m.add_load("motor", {.on = "one", .moment = {0.5, 0, 0}});
  Simulation s(m.compile(), options());
  run_to(s, 1);
  const double alpha = 0.5 / (0.002 + 0.05 / 9 + 0.007);
  expect_near(channel(s, "joint.three.velocity"), -alpha, 1e-6 * alpha);
}

/// Two gears between the same shafts: of one ratio one is too many, of two ratios nothing turns.
TEST(ContradictingCouplings, AreNamed) {
  const auto warnings = [](const std::string& second) {
    return simulation_of(R"y(
gravity: [0, 0, 0]
bodies:
  a: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}
  b: {mass: 1, com: [1, 0, 0], inertia: [1, 1, 1]}
  c: {mass: 1, com: [2, 0, 0], inertia: [1, 1, 1]}
joints:
  one: {type: revolute, between: [ground, a], at: [0, 0, 0], axis: [0, 0, 1]}
  two: {type: revolute, between: [ground, b], at: [1, 0, 0], axis: [0, 0, 1]}
  three: {type: revolute, between: [ground, c], at: [2, 0, 0], axis: [0, 0, 1]}
constraints:
  first: {type: gear, joints: [one, two], ratio: 2}
  second: )y" + second + "\n  third: {type: gear, joints: [two, three], ratio: -1}\n",
                         spec::Simulation::Formulation::relative)
        .warnings();
  };
  EXPECT_THAT(
      warnings("{type: gear, joints: [one, two], ratio: 3}"),
      testing::ElementsAre(testing::HasSubstr(
          "constraints 'first', 'second' contradict one another: together they lock joints 'one', 'two'")));
  EXPECT_THAT(warnings("{type: gear, joints: [one, three], ratio: 2}"),
              testing::ElementsAre(testing::HasSubstr("constraints 'first', 'second', 'third'")));
  for (const char* agrees :
       {"{type: gear, joints: [one, two], ratio: 2}", "{type: gear, joints: [one, three], ratio: -2}"})
    EXPECT_THAT(warnings(agrees), testing::IsEmpty());
}

}  // namespace
}  // namespace mimbre::test::couplings_test
