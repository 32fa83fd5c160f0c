#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/output_schema.h"
#include "app/program.h"

/// mimbre kinematics and mimbre inverse-dynamics.
namespace mimbre::app_test::motion_commands_test {
namespace {

using testing::HasSubstr;

class MotionCommands : public ProgramTest {
 protected:
  /// A pendulum that a drive swings; an input is a torque besides.
  std::string pendulum() {
    const fs::path path = folder / "pendulum.yaml";
    write_file(path, R"yaml(mimbre: 1
gravity: [0, 0, 0]
bodies: {bob: {mass: 2, com: [0, 0, -0.5], inertia: [0.1, 0.1, 0.1]}}
joints: {pin: {type: revolute, between: [ground, bob], at: [0, 0, 0], axis: [0, 1, 0], drive: {position: 3*t}}}
inputs: {push: {start: 0, unit: N m}}
actuators: {motor: {joint: pin, torque: push}}
simulation: {end: 1}
)yaml");
    return path.string();
  }
  /// A slider-crank whose crank turns uniformly; at t = 0.5 and 1 the slider turns back.
  std::string crank(const std::string& phase = "0") {
    const fs::path path = folder / "crank.yaml";
    write_file(path, R"yaml(mimbre: 1
gravity: [0, 0, 0]
parameters: {phase: )yaml" +
                         phase + R"yaml(}
bodies:
  crank: {mass: 1, com: [0.05, 0, 0], inertia: [1, 1, 1]}
  rod: {mass: 1, com: [0.2, 0, 0], inertia: [1, 1, 1]}
  slider: {mass: 1, com: [0.4, 0, 0], inertia: [1, 1, 1]}
joints:
  crank: {type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, -1, 0], drive: {position: 2*pi*t + phase}}
  pin: {type: revolute, between: [crank, rod], at: [0.1, 0, 0], axis: [0, -1, 0]}
  slide: {type: prismatic, between: [ground, slider], at: [0.4, 0, 0], axis: [1, 0, 0]}
  wrist: {type: revolute, between: [rod, slider], at: [0.4, 0, 0], axis: [0, -1, 0], cut: always}
simulation: {end: 1.2}
)yaml");
    return path.string();
  }
};

TEST_F(MotionCommands, AnswersFollowTheSchema) {
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"kinematics", crank(), "--json"},
        std::vector<std::string>{"inverse-dynamics", crank(), "--json"}}) {
    const Outcome outcome = run(words);
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    expect_schema(outcome.out);
  }
}

TEST_F(MotionCommands, AnInputActsBesidesTheForceThatIsFound) {
  for (const double push : {0.0, 0.7}) {
    const Outcome outcome =
        run({"inverse-dynamics", pendulum(), "--input", "push=" + std::to_string(push), "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NEAR(outcome.json().at("forces").at("pin").at("largest").number(), -push, 1e-12);
  }
  EXPECT_EQ(run({"kinematics", pendulum(), "--input", "push=1"}).code, 0);
  const Outcome refused = run({"inverse-dynamics", pendulum(), "--input", "push"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("--input push: NAME=VALUE is needed"));
  EXPECT_NE(run({"kinematics", pendulum(), "--input", "pull=1"}).code, 0);
}

/// The instants fall on the dead centres, where the slider is at rest.
TEST_F(MotionCommands, ReversalsAtInstantsAreFoundToo) {
  for (const char* steps : {"12", "120", "7"}) {
    const Outcome outcome =
        run({"kinematics", crank(), "--from", "0.1", "--to", "1.3", "--steps", steps, "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    std::vector<double> times;
    const test::Json json = outcome.json();
    const test::Json special = json.at("special");
    for (std::size_t k = 0; k < special.size(); ++k)
      if (special.at(k).at("joint").text() == "slide") times.push_back(special.at(k).at("time").number());
    ASSERT_EQ(times.size(), 2u) << steps;
    EXPECT_NEAR(times[0], 0.5, 1e-8);
    EXPECT_NEAR(times[1], 1, 1e-8);
  }
}

/// The drive turns the crank from the start; the force is looked for at the slider, which moves then.
TEST_F(MotionCommands, AForceElsewhereStartsWithTheMechanismsMotion) {
  const Outcome outcome =
      run({"inverse-dynamics", crank("0.6"), "--to", "0.3", "--force", "slide", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_LT(outcome.json().at("residual").number(), 1e-10);
}

}  // namespace
}  // namespace mimbre::app_test::motion_commands_test
