#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "forces/table.h"
#include "support/simulate.h"

/// Dry friction in joints: sticking that does not creep, sliding, stick–slip.
namespace mimbre::friction_test {
namespace {

using namespace test;

/// A block of 2 kg on a slope of 30 degrees, down which it slides.
std::string slope(double coefficient, const std::string& more, const std::string& initial = "assembled") {
  const double g = 9.81, angle = std::numbers::pi / 6, weight = 2 * g;
  return fmt::format(R"y(
gravity: [{}, 0, {}]
initial: {}
bodies: {{block: {{mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}}}
joints: {{guide: {{type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0]}}}}
frictions: {{base: {{joint: guide, force: {}, {}}}}}
outputs: [{{name: x, joint: guide}}, {{name: v, joint_velocity: guide}}]
simulation: {{step: 0.01, end: 1}}
)y",
                     g * std::sin(angle), -g * std::cos(angle), initial,
                     coefficient * weight * std::cos(angle), more);
}

class Friction : public testing::TestWithParam<Formulation> {};

TEST_P(Friction, ABlockOnASlopeStaysWhereItIs) {
  Simulation settled = simulation_of(slope(0.6, "sticking: 1e-5", "equilibrium"), GetParam(), 0.01);
  const double start = channel(settled, "x");
  // The bristles hold it at the part of their bend that the weight is of the limit.
  EXPECT_NEAR(start, 1e-5 * std::tan(std::numbers::pi / 6) / 0.6, 1e-10);
  for (int k = 0; k < 10000; ++k) ASSERT_TRUE(settled.step().ok());
  EXPECT_NEAR(channel(settled, "x"), start, 1e-9);

  Simulation dropped = simulation_of(slope(0.6, "sticking: 1e-5"), GetParam(), 0.01);
  for (int k = 0; k < 100; ++k) ASSERT_TRUE(dropped.step().ok());
  const double then = channel(dropped, "x");
  for (int k = 0; k < 10000; ++k) ASSERT_TRUE(dropped.step().ok());
  EXPECT_NEAR(channel(dropped, "x"), then, 1e-9);
}

/// With the acceleration of what slides from the first instant, whatever the step, also beside a wheel that
/// is braked already, and whose bristles stay bent.
TEST_P(Friction, WhatCannotStickSlidesFromTheFirstStep) {
  for (const double step : {0.01, 0.001}) {
    Simulation simulation = simulation_of(fmt::format(R"y(
gravity: [3, 0, -9.81]
bodies:
  block: {{mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}
  held: {{mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}
  wheel: {{mass: 1, com: [0, 0, 0], inertia: [0.2, 0.2, 0.2]}}
joints:
  guide: {{type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0]}}
  other: {{type: prismatic, between: [ground, held], at: [0, 1, 0], axis: [1, 0, 0]}}
  axle: {{type: revolute, between: [ground, wheel], at: [0, 2, 0], axis: [0, 1, 0], velocity: 1}}
frictions:
  slides: {{joint: guide, force: 1, sticking: 1e-9}}
  sticks: {{joint: other, force: 7}}
  brake: {{joint: axle, torque: 0.5}}
outputs:
  - {{name: x, joint: guide}}
  - {{name: v, joint_velocity: guide}}
  - {{name: still, joint: other}}
  - {{name: rate, joint_velocity: axle}}
simulation: {{step: {}, end: 1}}
)y",
                                                      step),
                                          GetParam(), step);
    for (int k = 1; k <= 10; ++k) {
      ASSERT_TRUE(simulation.step().ok());
      const double t = step * k;
      EXPECT_NEAR(channel(simulation, "v"), 2.5 * t, 1e-8) << k;
      EXPECT_NEAR(channel(simulation, "x"), 1.25 * t * t, 1e-10) << k;
      EXPECT_NEAR(channel(simulation, "still"), 0, 5e-5) << k;
      EXPECT_NEAR(channel(simulation, "rate"), 1 - 2.5 * t, 1e-4) << k;
    }
  }
}

/// Four hinges of a loop rub and bring it to rest, where the bristles stop to matter the stiffer they are:
/// Newton has to find the narrow range in which they stick between sliding forth and back.
TEST_P(Friction, HoweverStiffTheBristlesALoopComesToRest) {
  const auto rest = [&](double sticking) {
    std::string frictions;
    for (const char joint : {'a', 'b', 'c', 'd'})
      frictions += fmt::format("{0}: {{joint: {0}, torque: 1, sticking: {1}}}, ", joint, sticking);
    Simulation simulation = simulation_of(fmt::format(R"y(
bodies:
  crank: {{mass: 1, com: [0, 0, 0.25], inertia: [0.02, 0.02, 0.001]}}
  rod: {{mass: 2, com: [0.5, 0, 0.5], inertia: [0.001, 0.17, 0.17]}}
  rocker: {{mass: 1, com: [1, 0, 0.25], inertia: [0.02, 0.02, 0.001]}}
joints:
  a: {{type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 1, 0], velocity: 1}}
  b: {{type: revolute, between: [crank, rod], at: [0, 0, 0.5], axis: [0, 1, 0]}}
  c: {{type: revolute, between: [rod, rocker], at: [1, 0, 0.5], axis: [0, 1, 0]}}
  d: {{type: revolute, between: [ground, rocker], at: [1, 0, -0.2], axis: [0, 1, 0]}}
frictions: {{{}}}
outputs: [{{name: angle, joint: a}}, {{name: rate, joint_velocity: a}}]
simulation: {{step: 0.005, end: 1}}
)y",
                                                      frictions),
                                          GetParam(), 0.005);
    for (int k = 0; k < 200; ++k) EXPECT_TRUE(simulation.step().ok()) << sticking;
    EXPECT_NEAR(channel(simulation, "rate"), 0, 1e-6);
    return channel(simulation, "angle");
  };
  const double soft = rest(1e-5);
  for (const double sticking : {1e-6, 1e-7, 1e-8, 1e-9, 1e-10}) EXPECT_NEAR(rest(sticking), soft, 2e-5);
}

TEST_P(Friction, ShortBristlesHoldABlockAtOnce) {
  for (const double sticking : {1e-5, 1e-7, 1e-9})
    for (const double share : {0.1, 0.5, 0.86, 0.99}) {
      Simulation simulation =
          simulation_of(slope(std::tan(std::numbers::pi / 6) / share, fmt::format("sticking: {}", sticking)),
                        GetParam(), 0.01);
      for (int k = 0; k < 50; ++k) ASSERT_TRUE(simulation.step().ok()) << sticking << ' ' << share;
      // Half of the limit times the bend is stored, the rest of the load's work slides away.
      const double slides = share > 0.5 ? (share - 0.5) / (1 - share) : 0;
      EXPECT_LT(channel(simulation, "x"), (1 + slides) * sticking) << sticking << ' ' << share;
      EXPECT_NEAR(channel(simulation, "v"), 0, 1e-3 * sticking) << sticking << ' ' << share;
    }
}

TEST_P(Friction, AboveTheAngleOfFrictionItSlides) {
  Simulation simulation = simulation_of(slope(0.3, "sticking: 1e-9"), GetParam(), 0.001);
  const double angle = std::numbers::pi / 6, acceleration = 9.81 * (std::sin(angle) - 0.3 * std::cos(angle));
  for (int k = 0; k < 100; ++k) ASSERT_TRUE(simulation.step().ok());
  const double v = channel(simulation, "v"), x = channel(simulation, "x"), start = simulation.time(),
               lost = simulation.energy().dissipated;
  for (int k = 0; k < 1000; ++k) ASSERT_TRUE(simulation.step().ok());
  const double t = simulation.time() - start, moved = channel(simulation, "x") - x;
  EXPECT_NEAR(channel(simulation, "v") - v, acceleration * t, 1e-6 * acceleration);
  EXPECT_NEAR(moved, v * t + 0.5 * acceleration * t * t, 1e-6 * acceleration);
  EXPECT_NEAR(simulation.energy().dissipated - lost, 0.3 * 2 * 9.81 * std::cos(angle) * moved, 1e-6);
  EXPECT_NEAR(simulation.energy().numerical, 0, 1e-4);
}

/// The limit by the joint's own reaction, which a signal samples.
TEST_P(Friction, TheJointsReactionMayBeItsLoad) {
  const auto text = [](double coefficient) {
    return fmt::format(R"y(
gravity: [4.905, 0, -8.4957092]
bodies: {{block: {{mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}}}
joints: {{guide: {{type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0]}}}}
signals: {{normal: {{value: "abs(fz)", every: 0.001}}}}
frictions: {{base: {{joint: guide, force: "{}*normal"}}}}
outputs: [{{name: x, joint: guide}}, {{name: v, joint_velocity: guide}}, {{name: fz, joint_force: guide, component: fz}}]
simulation: {{step: 0.001, end: 1}}
)y",
                       coefficient);
  };
  Simulation holds = simulation_of(text(0.7), GetParam(), 1e-3),
             slides = simulation_of(text(0.3), GetParam(), 1e-3);
  for (int k = 0; k < 200; ++k) {
    ASSERT_TRUE(holds.step().ok());
    ASSERT_TRUE(slides.step().ok());
  }
  const double x = channel(holds, "x"), v = channel(slides, "v");
  for (int k = 0; k < 1000; ++k) {
    ASSERT_TRUE(holds.step().ok());
    ASSERT_TRUE(slides.step().ok());
  }
  EXPECT_NEAR(channel(holds, "x"), x, 1e-9);
  EXPECT_NEAR(channel(slides, "v") - v, 4.905 - 0.3 * 8.4957092, 1e-6);
}

/// Shaken by forces that never reach the limit, and by a limit that varies, it does not creep.
TEST_P(Friction, ShakingBelowTheLimitMovesNothing) {
  const std::string text = R"y(
gravity: [0, 0, 0]
bodies: {block: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {guide: {type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0]}}
frictions: {base: {joint: guide, force: "12 + 2*sin(31*t)", sticking: 1e-5}}
actuators: {shaker: {joint: guide, force: "4 + 4*sin(20*t)"}}
outputs: [{name: x, joint: guide}]
simulation: {step: 0.001, end: 1}
)y";
  Simulation simulation = simulation_of(text, GetParam(), 0.001);
  const double period = 2 * std::numbers::pi;  // of both
  double first = 0, sum = 0;
  int count = 0;
  for (int turn = 0; turn < 5; ++turn) {
    sum = 0;
    count = 0;
    while (simulation.time() < (turn + 1) * period) {
      ASSERT_TRUE(simulation.step().ok());
      sum += channel(simulation, "x");
      ++count;
    }
    if (turn == 0) first = sum / count;
  }
  EXPECT_NEAR(sum / count, first, 2e-8);
  EXPECT_LT(std::abs(channel(simulation, "x")), 1e-5);
}

/// The period of a block on a belt, which a spring holds: it sticks until the spring pulls with the static
/// limit, and slides, by the limit at its speed, until it has the belt's speed again; without bristles, each
/// slide integrated to the instant at which it ends.
double period_of(double belt, double stiffness, double level, double ratio, double stribeck) {
  const auto limit = [&](double speed) {
    return level * (1 + (ratio - 1) * std::exp(-std::pow(speed / stribeck, 2)));
  };
  double x = ratio * level / stiffness * (1 + 1e-9), v = belt, t = 0;
  const double h = 1e-6;
  const auto rate = [&](double at_x, double at_v) { return limit(belt - at_v) - stiffness * at_x; };
  bool slid = false;
  while (!slid || v < belt) {
    const double a1 = rate(x, v), v2 = v + 0.5 * h * a1, a2 = rate(x + 0.5 * h * v, v2),
                 v3 = v + 0.5 * h * a2, a3 = rate(x + 0.5 * h * v2, v3), v4 = v + h * a3,
                 a4 = rate(x + h * v3, v4);
    x += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    t += h;
    slid = slid || v < 0;
  }
  return t + (ratio * level / stiffness - x) / belt;
}

TEST_P(Friction, StickSlipHasItsPeriod) {
  const double belt = 0.1, stiffness = 100, fast = 1, ratio = 2, stribeck = 1e-3;
  const std::string text = fmt::format(R"y(
gravity: [0, 0, 0]
bodies:
  belt: {{mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
  block: {{mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints:
  run: {{type: prismatic, between: [ground, belt], at: [0, 0, 0], axis: [1, 0, 0], drive: {{position: "{}*t"}}}}
  rub: {{type: prismatic, between: [belt, block], at: [0, 0, 0], axis: [1, 0, 0]}}
frictions: {{dry: {{joint: rub, force: {}, static_ratio: {}, stribeck: {}, sticking: 2e-6, settling: 1e-4}}}}
springs: {{held: {{between: [ground, block], at: [[-1, 0, 0], [0, 0, 0]], elastic: {{stiffness: {}, zero: 1}}}}}}
outputs: [{{name: x, position: block, component: x}}, {{name: v, joint_velocity: rub}}]
simulation: {{step: 0.0001, end: 5}}
)y",
                                       belt, fast, ratio, stribeck, stiffness);
  Simulation simulation = simulation_of(text, GetParam(), 1e-4);
  const double period = period_of(belt, stiffness, fast, ratio, stribeck);
  std::vector<double> peaks;
  double before = 0, last = 0;
  while (peaks.size() < 6 && simulation.time() < 6) {
    ASSERT_TRUE(simulation.step().ok());
    const double x = channel(simulation, "x");
    if (last > before && last >= x && last > 0.015) peaks.push_back(simulation.time());
    before = last;
    last = x;
  }
  ASSERT_EQ(peaks.size(), 6u);
  EXPECT_NEAR((peaks.back() - peaks[1]) / 4, period, 2e-3 * period);
}

/// In a hinge with a torque, on a joint of the tree and on a cut one.
TEST_P(Friction, BrakesATurningWheelInTheTimeThatItTakes) {
  for (const bool cut : {false, true}) {
    const std::string text = fmt::format(R"y(
gravity: [0, 0, 0]
bodies: {{wheel: {{mass: 1, com: [0, 0, 0], inertia: [0.2, 0.2, 0.2]}}}}
joints: {}
frictions: {{brake: {{joint: axle, torque: 0.5}}}}
outputs: [{{name: rate, joint_velocity: axle}}, {{name: angle, joint: axle}}]
simulation: {{step: 0.001, end: 5}}
)y",
                                         cut ? R"y({
  free: {type: floating, between: [ground, wheel], velocity: [0, 0, 0, 0, 10, 0]},
  axle: {type: revolute, between: [ground, wheel], at: [0, 0, 0], axis: [0, 1, 0], cut: always}})y"
                                             : "{axle: {type: revolute, between: [ground, wheel], at: [0, 0, "
                                               "0], axis: [0, 1, 0], velocity: 10}}");
    Simulation simulation = simulation_of(text, GetParam(), 0.001);
    while (simulation.time() < 2) ASSERT_TRUE(simulation.step().ok());
    EXPECT_NEAR(channel(simulation, "rate"), 10 - 2 * 0.5 / 0.2, 3e-4);
    while (simulation.time() < 6) ASSERT_TRUE(simulation.step().ok());
    EXPECT_NEAR(channel(simulation, "rate"), 0, 1e-9);
    if (!cut) {  // whose angles count turns
      EXPECT_NEAR(channel(simulation, "angle"), 0.5 * 0.2 * 100 / 0.5, 2e-3);
    }
    EXPECT_NEAR(simulation.energy().dissipated, 10, 1e-3);
  }
}

/// A brake that was open while its wheel turned holds it where it is when it closes.
TEST_P(Friction, ABrakeThatWasOpenHoldsWhereItCloses) {
  Simulation simulation = simulation_of(R"y(
gravity: [0, 0, 0]
bodies: {wheel: {mass: 1, com: [0, 0, 0], inertia: [0.2, 0.2, 0.2]}}
joints: {axle: {type: revolute, between: [ground, wheel], at: [0, 0, 0], axis: [0, 0, 1]}}
inputs: {brake: {start: 0}, motor: {start: 0}}
actuators: {motor: {joint: axle, torque: motor}}
frictions: {brake: {joint: axle, torque: brake}}
outputs: [{name: angle, joint: axle}, {name: rate, joint_velocity: axle}]
simulation: {step: 0.001, end: 1}
)y",
                                        GetParam());
  const auto go = [&](double brake, double motor, int steps) {
    simulation.set_input(simulation.input("brake"), brake);
    simulation.set_input(simulation.input("motor"), motor);
    for (int k = 0; k < steps; ++k) ASSERT_TRUE(simulation.step().ok());
  };
  go(0, 2, 500);
  go(0, -2, 500);  // at rest again, a turn of half a radian and more away
  const double angle = channel(simulation, "angle");
  EXPECT_GT(angle, 1);
  EXPECT_NEAR(channel(simulation, "rate"), 0, 0.05);
  const double before = simulation.energy().numerical;
  go(10, 0, 1000);
  EXPECT_NEAR(channel(simulation, "angle"), angle, 1e-3);
  EXPECT_NEAR(channel(simulation, "rate"), 0, 1e-9);
  EXPECT_NEAR(simulation.energy().numerical, before, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Both, Friction, testing::Values(Formulation::relative, Formulation::natural));

/// Whatever the motion and the limit, the surfaces take energy and give none.
TEST(FrictionLaw, NeverFeedsEnergyIn) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  Compiled m;
  m.numbers = {1e-3, 1.5, 0.01, 0, 1e-3, 0, 0};
  m.arguments = {0};
  ElementData e;
  e.law = find_law("friction");
  e.measure = Measure::coordinate;
  e.count = 1;
  e.state_count = 4;
  const forces::LawRow<double>& row = forces::rows<double>[static_cast<std::size_t>(e.law)];
  std::vector<double> storage(static_cast<std::size_t>(element_storage(e)), 0), states(4, 0), signals{20};
  double x = 0, held = 0;
  for (int step = 0; step < 5000; ++step) {
    const double h = 1e-3 * std::pow(10.0, any(random));
    const LawContext<double> context{m, e, 0, signals.data(), states.data(), h};
    ElementState<double> s = element_state(e, storage.data());
    const double moved = 1e-3 * any(random) * (step % 3);
    x += moved;
    s.x[0] = x;
    s.v[0] = moved / h;
    row.law(context, s);
    ASSERT_LE(std::abs(s.force[0]), 20 * 1.5 * (1 + 1e-12));
    ElementEnergy energy;
    row.energy(context, s, energy);
    if (step > 0) {
      // By its force at the end of the step, but for that of the springs, which grows evenly over it.
      const double bent = s.states[0] - states[0], springs = 0.5 * 20 / m.numbers[0] * bent * bent;
      ASSERT_GE(s.force[0] * moved - springs - (energy.held - held), -1e-15) << step;
    }
    held = energy.held;
    std::copy(s.states, s.states + 4, states.begin());
  }
}

}  // namespace
}  // namespace mimbre::friction_test
