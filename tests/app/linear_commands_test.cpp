#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

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

/// The Iltis has a parameter `speed`, that of its start: the condition has to be named as one.
TEST_F(LinearCommands, FollowsModesOverAHeldCondition) {
  std::vector<std::string> words{"modes", MIMBRE_SOURCE_DIR "/examples/iltis/steady.yaml"};
  for (const char* part : {"arms=rigid", "links=rigid", "rods=rigid"})
    words.insert(words.end(), {"--set", part});
  words.insert(words.end(), {"--hold", "speed=10", "--find", "throttle", "--json", "--most", "8", "--over"});
  const auto with = [&](const std::string& over) {
    std::vector<std::string> all = words;
    all.push_back(over);
    return run(all);
  };
  const Outcome outcome = with("hold.speed=10:20:3");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  expect_schema(outcome.out);
  const test::Json found = outcome.json();
  EXPECT_EQ(found.at("parameter"), "speed");
  EXPECT_EQ(found.at("values"), (std::vector<double>{10, 15, 20}));
  // The speed that the throttle lets go: half as fast at twice the speed.
  double slowest[2] = {-1, -1};
  for (const test::Json branch : found.at("branches"))
    for (const int k : {0, 2}) {
      const test::Json real = branch.at("real")[k];
      if (real.is_number() && real < -1e-6) slowest[k / 2] = std::max(slowest[k / 2], real.number());
    }
  EXPECT_NEAR(slowest[0], -0.0119, 2e-4);
  EXPECT_NEAR(slowest[1], -0.00595, 1e-4);
  const Outcome both = with("speed=10:20:3");
  EXPECT_EQ(both.code, 2);
  EXPECT_THAT(both.err + both.out,
              HasSubstr("write hold.speed for the condition, model.speed for the parameter"));
  EXPECT_EQ(with("model.speed=10:12:2").code, 0);
  const Outcome unknown = with("hold.sped=10:20:3");
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(unknown.err + unknown.out, HasSubstr("yaw_rate or radius can be held"));
  const Outcome sought = with("throttle=0:1:3");
  EXPECT_EQ(sought.code, 2);
  EXPECT_THAT(sought.err + sought.out, HasSubstr("--find looks for this input"));
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

TEST_F(LinearCommands, ModesWriteFiles) {
  const fs::path h5 = folder / "modes.h5", vtk = folder / "vtk";
  const Outcome outcome = run({"modes", pendulum(), "-o", h5.string(), "--vtk", vtk.string()});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, h5.string() + "\n" + (vtk / "mode_1.pvd").string() + "\n");
  EXPECT_TRUE(fs::exists(h5));
  EXPECT_TRUE(fs::exists(vtk / "mode_1_023.vtp"));
  const Outcome json = run({"modes", pendulum(), "-o", h5.string(), "--json"});
  ASSERT_EQ(json.code, 0) << json.err;
  expect_schema(json.out);
}

TEST_F(LinearCommands, ModesRefuseFilesThatTheyCannotWrite) {
  const std::string model = pendulum();
  const auto refused = [&](const std::vector<std::string>& more, int code, const std::string& message) {
    std::vector<std::string> words{"modes", model};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.code, code) << message;
    EXPECT_THAT(outcome.err, HasSubstr(message));
  };
  refused({"-o", "modes.csv"}, 2, ".html or .h5");
  refused({"-o", "modes.h5", "--over", "length=0.3:0.9:4"}, 2, "--over");
  refused({"--vtk", "vtk", "--over", "length=0.3:0.9:4"}, 2, "--over");
  refused({"-o", (folder / "missing" / "modes.h5").string()}, 3, "modes.h5");
  const fs::path same = folder / "pendulum.h5";
  fs::copy_file(model, same);
  EXPECT_EQ(run({"modes", same.string(), "-o", same.string()}).code, 2);
}

TEST_F(LinearCommands, LineariseWritesBodePlots) {
  const std::string page = (folder / "bode.html").string();
  const Outcome without = run({"linearise", pendulum(), "-o", page});
  EXPECT_EQ(without.code, 2);
  EXPECT_THAT(without.err, HasSubstr("--frequencies"));
  const Outcome outcome = run({"linearise", pendulum(), "-o", page, "--frequencies", "0.1:10:30"});
  if (outcome.code == 3) GTEST_SKIP() << outcome.err;  // built without the pages
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(fs::exists(page));
  const std::string mute = (folder / "mute.yaml").string();
  write_file(mute, R"yaml(mimbre: 1
bodies: {bob: {mass: 1, com: [0, 0, -1], inertia: [1, 1, 1]}}
joints: {pin: {type: revolute, between: [ground, bob], at: [0, 0, 0], axis: [0, 1, 0]}}
inputs: {push: {start: 0, unit: N m}}
actuators: {motor: {joint: pin, torque: push}}
)yaml");
  const Outcome no_outputs = run({"linearise", mute, "-o", page, "--frequencies", "0.1:10:30"});
  EXPECT_EQ(no_outputs.code, 1);
  EXPECT_THAT(no_outputs.err, HasSubstr("the model has no outputs"));
}

}  // namespace
}  // namespace mimbre::app_test::linear_commands_test
