#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "support/exchange_importer.h"

/// Events in time of FMUs for model exchange.
namespace mimbre::test::model_exchange_events_test {
namespace {

class ModelExchangeEvents : public ExchangeTest {};

/// A road drops, another has kinks that come again, and a load has some.
TEST_P(ModelExchangeEvents, KnowsWhenFunctionsOfTimeJump) {
  const auto model = model_of(R"yaml(
bodies:
  front: {mass: 10, inertia: [1, 1, 1], com: [0, 0, 0.3]}
  rear: {mass: 10, inertia: [1, 1, 1], com: [1, 0, 0.3]}
joints:
  front: {type: prismatic, between: [ground, front], at: [0, 0, 0.3], axis: [0, 0, 1]}
  rear: {type: prismatic, between: [ground, rear], at: [1, 0, 0.3], axis: [0, 0, 1]}
roads:
  drop: {over: time, points: [[0, 0], [0.25, 0], [0.25, -0.05], [2, -0.05]]}
  teeth: {over: time, points: [[0, 0], [0.1, 0.01], [0.2, 0]], repeat: 0.2}
tyres:
  front: {on: front, road: drop, stiffness: 2e4, radius: 0.31}
  rear: {on: rear, road: teeth, stiffness: 2e4, radius: 0.32}
loads: {push: {on: rear, force: [0, 0, 1], scale: {table: [[0, 0], [0.33, 9], [0.4, 9]], interpolation: linear}}}
outputs:
  - {name: z, position: front, component: z}
  - {name: rear, position: rear, component: z}
)yaml");
  const FmuLibrary& of = library(model, "timed");
  ExchangeSolver solver(of, 1e-4);
  EXPECT_LE(difference(solver, accurate_run(model, of.fmu(), 0.45, 0.05), 0.05), 1e-6);
  EXPECT_EQ(solver.times(), 6);  // 0.1, 0.2, 0.25, 0.3, 0.33, 0.4
}

/// The acceleration of a drive jumps where its speed has a kink.
TEST_P(ModelExchangeEvents, KnowsTheKinksOfASpeed) {
  const auto model = model_of(R"yaml(
bodies:
  block: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0]}
  cart: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0]}
joints:
  guide: {type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0], spring: {stiffness: 50, damping: 1}}
  track:
    type: prismatic
    between: [block, cart]
    at: [0, 0, 0]
    axis: [1, 0, 0]
    drive: {speed: {table: [[0, 0], [0.13, 0.5], [0.27, -0.5], [0.9, 0]], interpolation: linear}}
outputs: [{name: x, joint: guide}, {name: way, joint: track}]
)yaml");
  const FmuLibrary& of = library(model, "speed_by_points");
  ExchangeSolver solver(of, 1e-3);
  EXPECT_LE(difference(solver, accurate_run(model, of.fmu(), 0.45, 0.05), 0.05), 1e-6);
  EXPECT_EQ(solver.times(), 2);
}

/// A block on a spring, pushed by what is added.
std::shared_ptr<const Model> pushed(const std::string& by) {
  return model_of(R"yaml(
bodies: {block: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0]}}
joints: {guide: {type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0], spring: {stiffness: 50, damping: 1}}}
outputs: [{name: x, joint: guide}]
)yaml" + by);
}

/// A road that falls back at the end of each period: the instants are no whole numbers of binary digits.
TEST_P(ModelExchangeEvents, EventsThatComeAgainAreToldOnce) {
  const auto model = model_of(R"yaml(
bodies: {block: {mass: 10, inertia: [1, 1, 1], com: [0, 0, 0.3]}}
joints: {guide: {type: prismatic, between: [ground, block], at: [0, 0, 0.3], axis: [0, 0, 1], spring: {damping: 100}}}
roads: {saw: {over: time, points: [[0, 0], [0.2, 0.002]], repeat: 0.2}}
tyres: {tyre: {on: block, road: saw, stiffness: 2e4, radius: 0.31}}
outputs: [{name: z, position: block, component: z}]
)yaml");
  const FmuLibrary& of = library(model, "saw");
  ExchangeSolver solver(of, 5e-4);
  EXPECT_LE(difference(solver, accurate_run(model, of.fmu(), 2.5, 0.05), 0.05), 1e-7);
  EXPECT_EQ(solver.times(), 12);
}

/// An importer that oversteps events is told of the next one ahead.
TEST_P(ModelExchangeEvents, NextEventsAreAhead) {
  const FmuLibrary& of = library(pushed(R"yaml(
loads: {push: {on: block, force: [1, 0, 0], scale: {table: [[0, 0], [0.1, 1], [0.25, 0], [0.3, 2], [0.31, 3]], interpolation: linear}}}
)yaml"),
                                 "overstepped");
  ExchangeInstance f(of);
  EXPECT_EQ(f.start_continuous().next, 0.1);
  EXPECT_EQ(f.set_time(0.27), fmi_ok);
  const ExchangeInstance::Update passed = f.event();
  EXPECT_EQ(passed.next, 0.3);
  EXPECT_EQ(f.set_time(1e16), fmi_ok);
  EXPECT_FALSE(f.event().has_next);
}

TEST_P(ModelExchangeEvents, TablesOfTheTimeTellTheirKinks) {
  const auto model = pushed(R"yaml(
signals: {force: {table: t, points: [[0, 0], [0.1037, 8], [0.1037, 0], [0.3021, 5]]}}
actuators: {motor: {joint: guide, force: force}}
)yaml");
  const FmuLibrary& of = library(model, "tabled");
  ExchangeSolver solver(of, 5e-3);
  EXPECT_LE(difference(solver, accurate_run(model, of.fmu(), 0.4, 0.05), 0.05), 1e-8);
  EXPECT_EQ(solver.times(), 1);  // beyond its ends a table goes on
}

/// Behind the event the force is infinite.
TEST_P(ModelExchangeEvents, UpdatesThatFailChangeNothing) {
  const FmuLibrary& of = library(pushed(R"yaml(
signals: {level: {table: t, points: [[0, 1], [0.1, 1], [0.1, 0], [0.2, 0], [0.2, 1], [0.3, 1]]}}
actuators: {motor: {joint: guide, force: 1/level}}
)yaml"),
                                 "failing_update");
  ExchangeInstance f(of);
  EXPECT_EQ(f.start_continuous().next, 0.1);
  EXPECT_EQ(f.set_time(0.1), fmi_ok);
  const std::vector<double> before = f.derivatives(), states = f.states();
  EXPECT_EQ(f.simple("EnterEventMode"), fmi_ok);
  const ExchangeInstance::Update failed = f.update();
  EXPECT_EQ(failed.status, fmi_discard);
  EXPECT_FALSE(failed.changed);
  EXPECT_EQ(f.states(), states);
  EXPECT_EQ(f.derivatives(), before);
  EXPECT_EQ(f.set_time(0.05), fmi_ok);
  EXPECT_EQ(f.update().next, 0.1);
  EXPECT_EQ(f.set_time(0.2), fmi_ok);  // over what cannot be
  EXPECT_EQ(f.update().status, fmi_ok);
}

INSTANTIATE_TEST_SUITE_P(Versions, ModelExchangeEvents, testing::Values(2, 3), name_of_version);

}  // namespace
}  // namespace mimbre::test::model_exchange_events_test
