#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mimbre/diagnostics.h"
#include "mimbre/model_builder.h"
#include "signals/block_models.h"
#include "support/simulate.h"

/// Blocks and events by the builder.
namespace mimbre::test::builder_test {
namespace {

ModelBuilder slider_builder() {
  ModelBuilder m;
  m.add_body("mass", {.mass = 1, .inertia = build::inertia(1, 1, 1)});
  m.add_joint("guide", {.type = spec::JointType::prismatic,
                        .between = {"ground", "mass"},
                        .at = Eigen::Vector3d(0, 0, 0),
                        .axis = Eigen::Vector3d(1, 0, 0)});
  m.add_output("place", {.kind = "joint", .of = "guide"});
  m.add_output("speed", {.kind = "joint_velocity", .of = "guide"});
  m.add_output("rise", {.kind = "joint_acceleration", .of = "guide"});
  m.set_simulation({.step = 0.002, .end = 1});
  return m;
}

TEST(BlocksOfTheBuilder, AreThoseOfTheModelFile) {
  ModelBuilder m = slider_builder();
  m.add_input("wanted", {.start = 1});
  m.add_block("servo", {.type = "pid",
                        .inputs = {"place", "wanted"},
                        .of = {"place", "wanted"},
                        .numbers = {{"kp", 60}, {"ki", 90}, {"kd", 12}, {"filter", 0.02}}});
  Eigen::MatrixXd A(2, 2), B(2, 1), C(2, 2);
  A << 0, 1, -40, -3;
  B << 0, 1;
  C << 1, 0, 0, 1;
  m.add_block("filter", {.type = "state_space",
                         .inputs = {"3*place"},
                         .of = {"place"},
                         .matrices = {{"A", A}, {"B", B}, {"C", C}},
                         .outputs = {"filter_a", "filter_b"}});
  m.add_block("noise", {.type = "noise", .numbers = {{"seed", 5}, {"deviation", 0.1}}, .every = 0.004});
  m.add_block("ramp",
              {.type = "rate_limit", .inputs = {"filter_b"}, .of = {"filter_b"}, .numbers = {{"rising", 2}}});
  m.add_signal("force", {.value = "servo + noise + ramp", .of = {"servo", "noise", "ramp"}});
  m.add_element("motor", {.law = "actuator", .joint = "guide", .signals = {"force"}});
  m.add_event("there", {.when = "place - 0.5",
                        .of = {"place", "speed"},
                        .direction = spec::Event::Direction::rising,
                        .set = {{"wanted", "0.9*speed"}}});
  Simulation built(m.compile());
  Simulation read = simulation_of(slider(R"y(
inputs: {wanted: 1}
signals:
  servo: {pid: place, setpoint: wanted, kp: 60, ki: 90, kd: 12, filter: 0.02}
  filter: {state_space: 3*place, A: [[0, 1], [-40, -3]], B: [0, 1], C: [[1, 0], [0, 1]], outputs: [a, b]}
  noise_: {noise: normal, seed: 5, deviation: 0.1, every: 0.004}
  ramp: {rate_limit: filter.b, rising: 2}
  force: servo + noise_ + ramp
actuators: {motor: {joint: guide, force: force}}
events: {there: {when: place - 0.5, direction: rising, set: {wanted: 0.9*speed}}}
)y",
                                         0.002),
                                  spec::Simulation::Formulation::relative);
  const auto one = built.channel("place"), other = read.channel("place");
  while (built.time() < 1 - 1e-9) {
    ASSERT_TRUE(built.step().ok());
    ASSERT_TRUE(read.step().ok());
    ASSERT_NEAR(built.value(one), read.value(other), 1e-12);
  }
  EXPECT_EQ(built.events().front().count, 1);
  EXPECT_NEAR(built.input_value(0), read.input_value(0), 1e-12);
}

TEST(BlocksOfTheBuilder, NameWhatIsWrong) {
  const auto refused = [](const build::Block& block) {
    ModelBuilder m = slider_builder();
    try {
      m.add_block("b", block);
      m.compile();
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  using testing::HasSubstr;
  EXPECT_THAT(refused({.type = "pdi"}), HasSubstr("there is no block 'pdi'"));
  EXPECT_THAT(refused({.type = "pid", .inputs = {"0"}, .numbers = {{"Kp", 1}}}),
              HasSubstr("did you mean 'kp'"));
  EXPECT_THAT(refused({.type = "delay", .inputs = {"0"}}), HasSubstr("'time' is missing"));
  EXPECT_THAT(refused({.type = "delay", .numbers = {{"time", 1}}}), HasSubstr("has 1 inputs, 0 are given"));
  EXPECT_THAT(refused({.type = "transfer_function", .inputs = {"0"}}), HasSubstr("'numerator' is missing"));
  EXPECT_THAT(refused({.type = "table", .inputs = {"0"}}), HasSubstr("has no points"));
  EXPECT_THAT(refused({.type = "pid", .inputs = {"1 +"}, .numbers = {{"kp", 1}}}), HasSubstr("inputs"));
}

}  // namespace
}  // namespace mimbre::test::builder_test
