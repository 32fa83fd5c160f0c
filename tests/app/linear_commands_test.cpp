#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/output_schema.h"
#include "app/program.h"

/// mimbre modes, mimbre linearise and mimbre trim.
namespace mimbre::app_test::linear_commands_test {
namespace {

using testing::HasSubstr;

class LinearCommands : public ProgramTest {
 protected:
  std::string pendulum() {
    const fs::path path = folder / "pendulum.yaml";
    write_file(path, R"yaml(mimbre: 1
parameters: {length: 0.5}
gravity: [0, 0, -9.81]
bodies: {bob: {mass: 1, com: [0, 0, -length], inertia: [1e-9, 1e-9, 1e-9]}}
joints: {pin: {type: revolute, between: [ground, bob], at: [0, 0, 0], axis: [0, 1, 0]}}
inputs: {push: {start: 0, unit: N m}}
actuators: {motor: {joint: pin, torque: push}}
outputs: [{name: angle, joint: pin}]
)yaml");
    return path.string();
  }
};

TEST_F(LinearCommands, ModesPrintsATable) {
  const Outcome outcome = run({"modes", pendulum()});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("point: equilibrium"));
  EXPECT_THAT(outcome.out, HasSubstr("0.704968"));  // √(9.81/0.5)/2π
  EXPECT_THAT(outcome.out, HasSubstr("'pin' 100 %"));
}

TEST_F(LinearCommands, AnswersFollowTheSchema) {
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"modes", pendulum(), "--json"},
        std::vector<std::string>{"modes", pendulum(), "--over", "length=0.3:0.9:4", "--speed", "rpm",
                                 "--json"},
        std::vector<std::string>{"linearise", pendulum(), "--json", "--frequencies", "0.1:10:5"}}) {
    const Outcome outcome = run(words);
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    expect_schema(outcome.out);
  }
}

TEST_F(LinearCommands, TrimFollowsTheSchemaAndModesTakeItsPoint) {
  std::vector<std::string> words{"trim", MIMBRE_SOURCE_DIR "/examples/iltis/steady.yaml"};
  for (const char* part : {"arms=rigid", "links=rigid", "rods=rigid"})
    words.insert(words.end(), {"--set", part});
  words.insert(words.end(),
               {"--hold", "speed=20", "--hold", "radius=200", "--find", "steering", "--find", "throttle"});
  const Outcome table = run(words);
  ASSERT_EQ(table.code, 0) << table.err;
  EXPECT_THAT(table.out, HasSubstr("steering"));
  words.emplace_back("--json");
  const Outcome outcome = run(words);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  expect_schema(outcome.out);
  words[0] = "modes";
  const Outcome modes = run(words);
  ASSERT_EQ(modes.code, 0) << modes.err;
  EXPECT_THAT(modes.out, HasSubstr("steady driving at 20 m/s, 2 m/s² to the left"));
  words.back() = "--at";
  words.emplace_back("start");
  EXPECT_EQ(run(words).code, 2);
}

TEST_F(LinearCommands, RefusesWhatIsNoPoint) {
  const Outcome outcome = run({"modes", pendulum(), "--at", "noon"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("--at noon: equilibrium, steady, start or a time in s is needed"));
}

TEST_F(LinearCommands, RefusesAnUnknownFormat) {
  const Outcome outcome = run({"linearise", pendulum(), "-o", "model.txt"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr(".h5, .mat or .json"));
}

}  // namespace
}  // namespace mimbre::app_test::linear_commands_test
