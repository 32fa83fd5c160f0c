#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "signals/block_models.h"
#include "support/models.h"
#include "support/simulate.h"

/// Events: when they happen, what follows from them, in both formulations.
namespace mimbre::test::events_test {
namespace {

using testing::HasSubstr;

class EventTimes : public testing::TestWithParam<Formulation> {};

std::string falling(const std::string& events, double step) {
  return fmt::format(R"y(
bodies: {{ball: {{mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}}}
joints: {{guide: {{type: prismatic, between: [ground, ball], at: [0, 0, 0], axis: [0, 0, 1], position: 3, velocity: 1}}}}
outputs: [{{name: height, joint: guide}}, {{name: speed, joint_velocity: guide}}]
simulation: {{step: {}, end: 2}}
inputs: {{caught: 0, motor: 0}}
actuators: {{motor: {{joint: guide, force: motor}}}}
{})y",
                     step, events);
}

/// z = 3 + t − g t²/2.
double time_of_height(double height) {
  const double g = 9.81;
  return (1 + std::sqrt(1 + 2 * g * (3 - height))) / g;
}

TEST_P(EventTimes, AFallingBodyHitsTheGround) {
  for (const double step : {0.01, 0.001, 0.0007}) {
    Simulation s = simulation_of(
        falling("events: {hit: {when: height, direction: falling, stop: true, set: {caught: speed}}}\n",
                step),
        GetParam());
    const auto count = s.channel("event.hit"), when = s.channel("event.hit.time");
    EXPECT_EQ(s.value(when), -1);
    while (!s.stopped() && s.time() < 2) ASSERT_TRUE(s.step().ok());
    ASSERT_TRUE(s.stopped());
    const double hit = time_of_height(0);
    EXPECT_NEAR(s.time(), hit, 1.5e-9);
    EXPECT_EQ(s.value(count), 1);
    EXPECT_EQ(s.value(when), s.time());
    EXPECT_EQ(s.events().front().first, s.time());
    EXPECT_NEAR(s.input_value(s.input("caught")), 1 - 9.81 * hit, 1e-7);
    EXPECT_LT(s.value(s.channel("height")), 0);
    EXPECT_GT(s.value(s.channel("height")), -1e-7);
    // The next step makes the rest of this one.
    ASSERT_TRUE(s.step().ok());
    EXPECT_FALSE(s.stopped());
    EXPECT_NEAR(s.time(), std::ceil(hit / step) * step, 1e-12);
    EXPECT_NEAR(s.value(s.channel("height")), 3 + s.time() - 0.5 * 9.81 * s.time() * s.time(), 1e-9);
  }
}

TEST_P(EventTimes, DirectionsAreTold) {
  Simulation s = simulation_of(falling(R"y(
events:
  up: {when: height, crosses: 3.02, direction: rising}
  down: {when: height, crosses: 3.02, direction: falling}
  both: {when: height - 3.02}
  top: {when: speed, direction: falling}
  never: {when: height, crosses: 10}
)y",
                                       0.01),
                               GetParam());
  while (s.time() < 1 - 1e-9) ASSERT_TRUE(s.step().ok());
  const auto events = s.events();
  const double rises = (1 - std::sqrt(1 - 2 * 9.81 * 0.02)) / 9.81, falls = time_of_height(3.02);
  EXPECT_EQ(events[0].count, 1);
  EXPECT_NEAR(events[0].first, rises, 1.5e-9);
  EXPECT_EQ(events[1].count, 1);
  EXPECT_NEAR(events[1].first, falls, 1.5e-9);
  EXPECT_EQ(events[2].count, 2);
  EXPECT_NEAR(events[2].first, rises, 1.5e-9);
  EXPECT_NEAR(events[2].last, falls, 1.5e-9);
  EXPECT_NEAR(events[3].first, 1 / 9.81, 1.5e-9);
  EXPECT_EQ(events[4].count, 0);
  EXPECT_TRUE(std::isnan(events[4].last));
  EXPECT_NEAR(s.value(s.channel("height")), 3 + 1 - 0.5 * 9.81, 1e-9);
}

/// A force that is switched on at a height acts from there on.
TEST_P(EventTimes, WhatTheySetActsFromThereOn) {
  for (const double step : {0.01, 0.0013}) {
    Simulation s = simulation_of(
        falling(
            "events: {engine: {when: height, crosses: 2, direction: falling, set: {motor: \"60 + 0*t\"}}}\n",
            step),
        GetParam());
    while (s.time() < 1.2) ASSERT_TRUE(s.step().ok());
    const double on = time_of_height(2), t = s.time() - on, speed = 1 - 9.81 * on;
    EXPECT_NEAR(s.value(s.channel("height")), 2 + speed * t + 0.5 * (30 - 9.81) * t * t, 1e-7);
    EXPECT_NEAR(s.value(s.channel("speed")), speed + (30 - 9.81) * t, 1e-6);
  }
}

/// A quarter of a pendulum's swing from rest at 1 rad: K(sin(1/2)) / ω, by the arithmetic-geometric mean.
TEST_P(EventTimes, APendulumPassesItsLowestPoint) {
  double a = 1, b = std::cos(0.5);
  for (int k = 0; k < 8; ++k) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  const double exact = std::numbers::pi / (2 * a) / std::sqrt(2 * 9.81 * 1.5 / 5);
  double coarse = 0, off = 0;
  for (const double step : {8e-5, 4e-5}) {
    Simulation s = simulation_of(fmt::format(R"y(
bodies: {{bob: {{mass: 2, com: [0, 0, -1.5], inertia: [0.5, 0.5, 0.5]}}}}
joints: {{hinge: {{type: revolute, between: [ground, bob], at: [0, 0, 0], axis: [0, 1, 0], position: 1}}}}
outputs: [{{name: angle, joint: hinge}}]
events: {{low: {{when: angle, stop: true}}}}
simulation: {{step: {}, end: 2, integrator: {{type: generalized_alpha, rho: 1}}}}
)y",
                                             step),
                                 GetParam());
    while (!s.stopped() && s.time() < 2) ASSERT_TRUE(s.step().ok());
    coarse = off;
    off = s.time() - exact;
  }
  // The integrator's error falls with the square of the step; what is left is that of the event.
  EXPECT_NEAR(off - (coarse - off) / 3, 0, 1e-9);
  EXPECT_LT(std::abs(off), 5e-9);
}

/// Events that are made by what others set, and thermostats that switch each other.
TEST_P(EventTimes, EventsFollowEachOther) {
  Simulation s = simulation_of(slider(R"y(
inputs: {push: 1, stage: 0}
actuators: {motor: {joint: guide, force: "3*push"}}
events:
  far: {when: place, crosses: 0.1, direction: rising, set: {push: -1, stage: 1}}
  near: {when: place, crosses: -0.1, direction: falling, set: {push: 1}}
  staged: {when: stage, crosses: 0.5, set: {stage: "stage + 1"}}
)y",
                                      0.002, 3),
                               GetParam());
  while (s.time() < 3 - 1e-9) ASSERT_TRUE(s.step().ok());
  const auto events = s.events();
  // 0.1 m at 3 m/s² from rest; the same on until it turns, and back: three times that in all to the other
  // end.
  const double quarter = std::sqrt(0.2 / 3);
  EXPECT_NEAR(events[0].first, quarter, 2e-9);
  EXPECT_EQ(events[2].count, 1);
  EXPECT_EQ(events[2].first, events[0].first);
  EXPECT_GE(events[1].count, 1);
}

TEST_P(EventTimes, TheyAreInTheState) {
  const std::string model = slider(R"y(
inputs: {push: 1}
signals: {smooth: {transfer_function: push, numerator: [1], denominator: [0.01, 1]}}
actuators: {motor: {joint: guide, force: "30*smooth"}}
events:
  far: {when: place, crosses: 0.02, direction: rising, set: {push: -1}}
  near: {when: place, crosses: -0.02, direction: falling, set: {push: 1}}
)y",
                                   0.002, 3);
  Simulation a = simulation_of(model, GetParam()), b = simulation_of(model, GetParam());
  for (int k = 0; k < 150; ++k) ASSERT_TRUE(a.step().ok());
  b.restore(Simulation::Snapshot::from_bytes(a.save().bytes()));
  ResultsRow one, other;
  for (int k = 0; k < 300; ++k) {
    ASSERT_TRUE(a.step().ok());
    ASSERT_TRUE(b.step().ok());
    a.sample(one);
    b.sample(other);
    ASSERT_EQ(one.time, other.time);
    ASSERT_TRUE(one.channels == other.channels) << k;
  }
  EXPECT_GT(a.events()[0].count, 1);
}

/// Events that only look leave the motion as it is, but for when a matrix is made anew.
TEST_P(EventTimes, WhatDoesNotActLeavesTheMotion) {
  const std::string model =
      four_bar_text({{"crank", ", velocity: 3"}}) +
      "outputs: [{name: angle, joint: crank}, {name: push, joint_force: rocker, component: fx}]\n"
      "simulation: {step: 0.01, end: 1, tolerance: 1e-8}\n";
  std::string events = "events:\n";
  for (int k = 0; k < 10; ++k)
    events += fmt::format("  e{0}: {{when: angle, crosses: {1}}}\n", k, 0.013 + 0.011 * k);
  events += "  pushed: {when: push, crosses: 1}\n";
  Simulation plain = simulation_of(model, GetParam()), watched = simulation_of(model + events, GetParam());
  while (plain.time() < 1 - 1e-9) {
    ASSERT_TRUE(plain.step().ok());
    ASSERT_TRUE(watched.step().ok());
    ASSERT_EQ(plain.time(), watched.time());
    ASSERT_NEAR(plain.value(plain.channel("angle")), watched.value(watched.channel("angle")), 1e-8);
  }
  double before = 0;
  for (const EventRecord& e : watched.events()) {
    if (e.name == "pushed") break;
    ASSERT_GE(e.count, 1) << e.name;
    EXPECT_GT(e.first, before);
    before = e.first;
  }
}

/// What crosses and comes back within one step is seen by shorter ones only; what touches is not crossed.
TEST_P(EventTimes, TouchAndGoWithinAStepIsNotSeen) {
  // The body's highest point, 1/(2 g) above where it starts, is after 0.1019 s.
  const double top = 3 + 0.5 / 9.81;
  const auto count = [&](double above, double step) {
    Simulation s = simulation_of(
        falling(fmt::format("events: {{grazes: {{when: height, crosses: {:.17g}}}}}\n", above), step),
        GetParam());
    run_to(s, 0.24);
    return s.events()[0].count;
  };
  // Above for ±0.0141 s around the top.
  EXPECT_EQ(count(top - 0.5 * 9.81 * 2e-4, 0.08), 0);
  EXPECT_EQ(count(top - 0.5 * 9.81 * 2e-4, 0.01), 2);
  EXPECT_EQ(count(top + 1e-6, 0.01), 0);
}

/// A run that goes on behind the event that stopped it, from what was saved there, has the same bits.
TEST_P(EventTimes, AStopIsInTheState) {
  const std::string model = falling(
      "events: {hit: {when: height, crosses: 1, direction: falling, stop: true, set: {motor: 30}}}\n", 0.01);
  Simulation a = simulation_of(model, GetParam()), b = simulation_of(model, GetParam());
  while (!a.stopped() && a.time() < 2) ASSERT_TRUE(a.step().ok());
  ASSERT_TRUE(a.stopped());
  b.restore(Simulation::Snapshot::from_bytes(a.save().bytes()));
  EXPECT_TRUE(b.stopped());
  ResultsRow one, other;
  for (int k = 0; k < 60; ++k) {
    ASSERT_TRUE(a.step().ok());
    ASSERT_TRUE(b.step().ok());
    a.sample(one);
    b.sample(other);
    ASSERT_EQ(one.time, other.time);
    ASSERT_TRUE(one.channels == other.channels) << k;
  }
  EXPECT_EQ(a.events()[0].count, b.events()[0].count);
}

/// A reaction that is too large is an event, too.
TEST_P(EventTimes, ForcesMayBeTheirCause) {
  Simulation s = simulation_of(R"y(
bodies: {bob: {mass: 2, com: [0, 0, -1], inertia: [0.1, 0.1, 0.1]}}
joints: {hinge: {type: revolute, between: [ground, bob], at: [0, 0, 0], axis: [0, 1, 0], position: 1.5}}
outputs: [{name: angle, joint: hinge}, {name: pull, joint_force: hinge, component: fz}]
events: {breaks: {when: pull, crosses: 40, stop: true}}
simulation: {step: 0.002, end: 2}
)y",
                               GetParam());
  while (!s.stopped() && s.time() < 2) ASSERT_TRUE(s.step().ok());
  ASSERT_TRUE(s.stopped());
  EXPECT_NEAR(s.value(s.channel("pull")), 40, 1e-5);
}

INSTANTIATE_TEST_SUITE_P(BothFormulations, EventTimes,
                         testing::Values(Formulation::relative, Formulation::natural));

TEST(EventErrors, NameWhatIsWrong) {
  const auto refused = [](const std::string& event) {
    return refusal_of(slider("inputs: {push: 0}\nevents: {e: {" + event + "}}\n", 0.01));
  };
  EXPECT_EQ(refused("when: place"), "accepted");
  EXPECT_THAT(refused("crosses: 1"), HasSubstr("when"));
  EXPECT_THAT(refused("when: xx"), HasSubstr("xx"));
  EXPECT_THAT(refused("when: place, direction: up"), HasSubstr("rising"));
  EXPECT_THAT(refused("when: place, set: {pusch: 1}"), HasSubstr("did you mean 'push'"));
  EXPECT_THAT(refused("when: place, set: {push: y}"), HasSubstr("y"));
  EXPECT_THAT(refused("when: place, stopp: true"), HasSubstr("stop"));
}

}  // namespace
}  // namespace mimbre::test::events_test
