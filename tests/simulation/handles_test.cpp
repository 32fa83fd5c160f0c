#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "mimbre/real_time.h"
#include "mimbre/simulation.h"
#include "mimbre/unknown_name.h"
#include "support/models.h"

/// Handles of nothing and numbers that are not finite: one answer of every call that takes them.
namespace mimbre::handles_test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                 infinity = std::numeric_limits<double>::infinity();

template <class Error, class Call>
std::string thrown(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing";
}

class WrongHandles : public ::testing::Test {
 protected:
  Simulation simulation{test::controlled_four_bar()};
};

TEST_F(WrongHandles, OfNothingAreOutOfRange) {
  const int channels = static_cast<int>(simulation.channels().size()),
            inputs = static_cast<int>(simulation.inputs().size()),
            bodies = static_cast<int>(simulation.model().spec().bodies.size());
  constexpr int lowest = std::numeric_limits<int>::min(), highest = std::numeric_limits<int>::max();
  const auto out = [](const auto& call) { return thrown<std::out_of_range>(call); };
  for (const int wrong : {-1, lowest, highest}) {
    EXPECT_THAT(out([&] { simulation.value({wrong}); }), StartsWith("value: there is no channel"));
    EXPECT_THAT(out([&] { simulation.pose({wrong}); }), StartsWith("pose: there is no body"));
    EXPECT_THAT(out([&] { simulation.set_input(wrong, 0); }), StartsWith("set_input: there is no input"));
    EXPECT_THAT(out([&] { simulation.input_value(wrong); }), StartsWith("input_value: there is no input"));
  }
  EXPECT_EQ(out([&] { simulation.value({channels}); }),
            "value: there is no channel " + std::to_string(channels) + "; they are counted from 0 to " +
                std::to_string(channels - 1));
  EXPECT_THAT(out([&] { simulation.pose({bodies}); }), HasSubstr("counted from 0 to"));
  EXPECT_THAT(out([&] { simulation.set_input(inputs, 0); }), HasSubstr("counted from 0 to"));
  EXPECT_THAT(out([&] { simulation.input_value(inputs); }), HasSubstr("counted from 0 to"));
  // The default of a handle is nobody's.
  EXPECT_THAT(out([&] { simulation.value(Simulation::Channel()); }), HasSubstr("no channel -1"));
  EXPECT_THAT(out([&] { simulation.pose(Simulation::Body()); }), HasSubstr("no body -1"));
  // The first and the last are there.
  for (const int right : {0, channels - 1}) EXPECT_EQ(out([&] { simulation.value({right}); }), "nothing");
  for (const int right : {0, bodies - 1}) EXPECT_EQ(out([&] { simulation.pose({right}); }), "nothing");
  for (const int right : {0, inputs - 1})
    EXPECT_EQ(out([&] { simulation.set_input(right, simulation.input_value(right)); }), "nothing");
}

TEST_F(WrongHandles, OfNamesThatAreNotThereAreUnknown) {
  EXPECT_THROW(simulation.channel("nobody"), UnknownName);
  EXPECT_THROW(simulation.body("nobody"), UnknownName);
  EXPECT_THROW(simulation.input("nobody"), UnknownName);
}

TEST_F(WrongHandles, NumbersThatAreNotFiniteAreInvalid) {
  const auto invalid = [](const auto& call) { return thrown<std::invalid_argument>(call); };
  simulation.step();
  const auto before = simulation.save();
  for (int k = 0; k < static_cast<int>(simulation.inputs().size()); ++k)
    for (const double wrong : {nan, infinity, -infinity}) {
      const std::string message = invalid([&] { simulation.set_input(k, wrong); });
      EXPECT_THAT(message, StartsWith("set_input: the value of input '" +
                                      simulation.inputs()[static_cast<std::size_t>(k)].name + "' is"));
    }
  for (const double wrong : {nan, infinity, -infinity, simulation.time(), simulation.time() - 1})
    EXPECT_THAT(invalid([&] { simulation.step_to(wrong); }), StartsWith("step_to: "));
  const auto after = simulation.save();
  EXPECT_EQ(before.bytes(), after.bytes()) << "nothing has changed";
  EXPECT_TRUE(simulation.step().ok());
}

TEST_F(WrongHandles, StartValuesThatAreNotFiniteAreRefused) {
  RunOptions options;
  options.inputs[simulation.inputs()[0].name] = nan;
  EXPECT_THROW(Simulation(test::controlled_four_bar(), options), InputError);
  options.inputs = {{"nobody", 0}};
  EXPECT_THROW(Simulation(test::controlled_four_bar(), options), UnknownName);
}

TEST_F(WrongHandles, PlacesOfSnapshotsThatAreNotThereAreOutOfRange) {
  RealTimeOptions options;
  options.snapshots = 2;
  RealTimeLoop loop(simulation, options);
  using Kind = RealTimeRequest::Kind;
  for (const Kind kind : {Kind::save, Kind::restore})
    for (const int place : {-1, 2})
      EXPECT_THAT(thrown<std::out_of_range>([&] {
                    loop.request({kind, place});
                  }),
                  StartsWith("request: there is no place"));
  EXPECT_TRUE(loop.request({Kind::save, 1}));
}

/// Cut to the range, counted, and said with the warnings.
TEST(InputRange, IsSaidWhereValuesWereCut) {
  const auto model = test::model_of(R"(
inputs: {u: {start: 0, range: [-5, 5]}, w: {start: 0, hold: linear, range: [0, 1]}, free: 0}
bodies: {b: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {j: {type: revolute, between: [ground, b], at: [0, 0, 0], axis: [0, 0, 1]}}
actuators: {m: {joint: j, torque: u + w + free}}
simulation: {step: 0.01, end: 1}
)");
  Simulation simulation(model);
  const auto said = [](const Simulation& s) {
    std::string all;
    for (const std::string& text : s.warnings())
      if (text.find("beyond its range") != std::string::npos) all += text + "\n";
    return all;
  };
  simulation.set_input(simulation.input("u"), 5);
  simulation.set_input(simulation.input("free"), 1e9);
  simulation.step();
  EXPECT_EQ(said(simulation), "");
  for (const double value : {7., 7., -9., 1., 6.}) {
    simulation.set_input(simulation.input("u"), value);
    EXPECT_EQ(simulation.input_value(simulation.input("u")), std::clamp(value, -5., 5.));
    simulation.step();
  }
  EXPECT_EQ(said(simulation),
            "input 'u': 3 values were beyond its range [-5, 5] and cut to it, the first at t = 0.01 s; the "
            "farthest was -9\n");
  // It is part of what was observed.
  const auto here = simulation.save();
  simulation.set_input(simulation.input("w"), 2);
  EXPECT_THAT(said(simulation), HasSubstr("input 'w': 1 value was beyond its range [0, 1]"));
  simulation.restore(here);
  EXPECT_THAT(said(simulation), Not(HasSubstr("'w'")));
  simulation.restart(here);
  EXPECT_EQ(said(simulation), "");
  // So are start values.
  RunOptions options;
  options.inputs["u"] = 12;
  EXPECT_THAT(said(Simulation(model, options)), HasSubstr("input 'u': 1 value was beyond its range [-5, 5]"));
}

/// What an event sets is cut, too.
TEST(InputRange, IsSaidOfEvents) {
  Simulation simulation(test::model_of(R"(
inputs: {u: {start: 0, range: [0, 5]}}
bodies: {b: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {j: {type: revolute, between: [ground, b], at: [0, 0, 0], axis: [0, 0, 1]}}
actuators: {m: {joint: j, torque: u}}
events: {now: {when: t, crosses: 0.025, set: {u: 8}}}
simulation: {step: 0.01, end: 1}
)"));
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(simulation.step().ok());
  EXPECT_EQ(simulation.input_value(0), 5);
  ASSERT_EQ(simulation.warnings().size(), 1u);
  EXPECT_THAT(
      simulation.warnings()[0],
      HasSubstr("input 'u': 1 value was beyond its range [0, 5] and cut to it, the first at t = 0.025"));
}

}  // namespace
}  // namespace mimbre::handles_test
