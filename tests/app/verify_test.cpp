#include <gmock/gmock.h>

#include "app/program.h"

namespace mimbre::app_test::verify_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Verify : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_file(folder / "pendulum.yaml", pendulum);
  }
};

TEST_F(Verify, SaysEverythingAboutBothRuns) {
  const Outcome outcome = run({"verify", "pendulum.yaml", "--step", "0.02", "--set", "length=2", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err << outcome.out;
  EXPECT_EQ(outcome.err, "");
  const auto json = outcome.json();
  EXPECT_EQ(json.at("status"), "ok");
  EXPECT_EQ(json.at("model"), "pendulum.yaml");
  EXPECT_EQ(json.at("agree"), true);
  EXPECT_EQ(json.at("step"), 0.02);
  EXPECT_EQ(json.at("formalism"), "index3");
  EXPECT_EQ(json.at("half_step").at("step"), 0.01);
  EXPECT_EQ(json.at("coordinates").at("relative"), 1);
  EXPECT_EQ(json.at("constraints").at("relative"), 0);
  for (const char* formulation : {"relative", "natural"}) {
    EXPECT_EQ(json.at("steps").at(formulation), 50);
    EXPECT_EQ(json.at("half_step").at("steps").at(formulation), 100);
    EXPECT_GE(json.at("iterations").at(formulation), 50);
    EXPECT_GT(json.at("cpu_seconds").at(formulation), 0);
    EXPECT_LT(json.at("position_violation").at(formulation), 1e-6);
    EXPECT_LT(json.at("velocity_violation").at(formulation), 1e-6);
    EXPECT_TRUE(json.at("energy_drift").at(formulation).is_number());
  }
  std::vector<std::string> names;
  for (const auto& channel : json.at("channels")) {
    names.push_back(channel.at("name"));
    EXPECT_LE(channel.at("relative_difference"), 0.05) << channel;
    EXPECT_LE(channel.at("half_step_relative_difference"), 0.01) << channel;
    EXPECT_TRUE(channel.at("max_difference").is_number());
    EXPECT_TRUE(channel.at("time").is_number());
    EXPECT_TRUE(channel.at("unit").is_string());
  }
  EXPECT_THAT(names, testing::IsSupersetOf({"angle", "bob.z", "energy.kinetic"}));
  EXPECT_THAT(names, Not(testing::Contains(testing::StartsWith("solver."))));
  EXPECT_THAT(names, Not(testing::Contains("energy.numerical")));
}

TEST_F(Verify, WithoutHalfTheStep) {
  const Outcome outcome = run({"verify", "pendulum.yaml", "--until", "0.5", "--no-refine", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_FALSE(outcome.json().contains("half_step"));
  EXPECT_TRUE(outcome.json().at("refinement_ratio").is_null());
  EXPECT_FALSE(outcome.json().at("channels")[0].contains("ratio"));
}

TEST_F(Verify, ATableForPeople) {
  const Outcome some = run({"verify", "pendulum.yaml", "--until", "0.5"});
  ASSERT_EQ(some.code, 0) << some.err;
  EXPECT_THAT(some.out, testing::StartsWith("The formulations "));
  EXPECT_THAT(some.out, HasSubstr("largest difference"));
  EXPECT_THAT(some.out, HasSubstr("energy drift"));
  EXPECT_THAT(some.out, HasSubstr("--all shows them"));
  const Outcome all = run({"verify", "pendulum.yaml", "--until", "0.5", "--all"});
  EXPECT_THAT(all.out, Not(HasSubstr("--all")));
  EXPECT_GT(all.out.size(), some.out.size());
}

TEST_F(Verify, SaysWhichFormulationFailed) {
  // The load's law is not a number beyond t = 0.5 s.
  std::string model = pendulum;
  model.insert(model.find("outputs:"),
               "loads:\n  push: {on: bob, at: [length, 0, 0], force: [0, 0, 1], scale: sqrt(0.5001-t)}\n");
  write_file(folder / "failing.yaml", model);
  const Outcome outcome = run({"verify", "failing.yaml", "--json"});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("the relative formulation failed with the step 0.01 s: "));
  EXPECT_THAT(outcome.err, HasSubstr("the natural formulation failed with the step 0.01 s: "));
  EXPECT_THAT(outcome.err, HasSubstr("t = 0.51 s"));
  const auto json = outcome.json();
  EXPECT_EQ(json.at("status"), "failed");
  EXPECT_EQ(json.at("agree"), false);
  EXPECT_EQ(json.at("steps").at("relative"), 50);
  EXPECT_EQ(json.at("failures").size(), 2u);
  EXPECT_TRUE(json.at("channels").empty());
}

TEST_F(Verify, ElastodynamicsHasNothingToCompareWith) {
  const std::string crank = std::string(MIMBRE_SOURCE_DIR) + "/examples/slider-crank/slider-crank.yaml";
  const Outcome outcome = run({"verify", crank, "--set", "approach=elastodynamics"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("body 'rod' bends by elastodynamics"));
  EXPECT_THAT(outcome.out, testing::IsEmpty());
}

TEST_F(Verify, BadModelsAndWrongUseAreToldApart) {
  EXPECT_EQ(run({"verify", "missing.yaml"}).code, 1);
  EXPECT_EQ(run({"verify"}).code, 2);
  EXPECT_EQ(run({"verify", "pendulum.yaml", "--step", "0"}).code, 2);
  EXPECT_EQ(run({"verify", "pendulum.yaml", "--formulation", "natural"}).code, 2);
  EXPECT_EQ(run({"verify", "pendulum.yaml", "--formalism", "none"}).code, 2);
}

/// The difference of two programs for the same equations is their error, which falls with the square of the
/// step.
TEST_F(Verify, TheFormulationsAgreeToTheSquareOfTheStep) {
  const Outcome outcome = run({"verify", "pendulum.yaml", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err << outcome.out;
  const auto json = outcome.json();
  EXPECT_EQ(json.at("agree"), true);
  EXPECT_GT(json.at("coordinates").at("natural"), json.at("coordinates").at("relative"));
  EXPECT_GT(json.at("constraints").at("natural"), 0);
  ASSERT_TRUE(json.at("refinement_ratio").is_number()) << outcome.out;
  EXPECT_NEAR(json.at("refinement_ratio").number(), 4, 0.4);
  for (const auto& channel : json.at("channels"))
    if (channel.at("name") == "angle") {
      EXPECT_GT(channel.at("max_difference"), 0);
      EXPECT_LT(channel.at("relative_difference"), 1e-2);
      EXPECT_NEAR(channel.at("ratio").number(), 4, 0.4);
    }
}

TEST_F(Verify, SaysOfEachChannelWhetherItAgrees) {
  const auto json = run({"verify", "pendulum.yaml", "--json"}).json();
  for (const auto& channel : json.at("channels")) {
    EXPECT_EQ(channel.at("agrees"), true) << channel;
    EXPECT_LE(channel.at("difference"), 0.01) << channel;
    EXPECT_TRUE(channel.contains("ratio"));
    EXPECT_LT(channel.at("step_error").at("relative"), 0.01) << channel;
  }
  EXPECT_EQ(json.at("repeated_steps").at("natural"), 0);
  EXPECT_EQ(json.at("without_repeats"), false);
}

TEST_F(Verify, NothingAgreesWhereNothingRan) {
  const Outcome outcome = run({"verify", "pendulum.yaml", "--until", "0", "--json"});
  EXPECT_EQ(outcome.json().at("agree"), false);
  EXPECT_THAT(outcome.err, HasSubstr("nothing to compare"));
  EXPECT_EQ(run({"verify", "pendulum.yaml", "--until", "0", "--strict"}).code, 4);
}

/// Energy and momentum stay, so that their ranges are nothing but errors.
TEST_F(Verify, WhatIsConstantIsMeasuredByItsSize) {
  write_file(folder / "free.yaml", R"(mimbre: 1
gravity: [0, 0, 0]
bodies:
  b: {mass: 5, com: [0, 0, 0], inertia: [1, 2, 3]}
joints:
  fly: {type: floating, between: [ground, b], at: [0, 0, 0], velocity: [1, 0.3, -0.2, 1, 0.5, 2]}
outputs:
  - {name: vx, velocity: b, component: x}
simulation: {step: 0.01, end: 10, output_interval: 0.1}
)");
  const Outcome outcome = run({"verify", "free.yaml", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.json().at("agree"), true) << outcome.out;
}

/// N four-bars in a row pass positions in which the couplers may fold: at this step they do, in one run.
TEST_F(Verify, AWrongBranchIsNoAgreement) {
  std::string model = "mimbre: 1\ngravity: [0, -9.81, 0]\nbodies:\n";
  const int loops = 4;
  for (int k = 0; k <= loops; ++k) {
    const std::string n = std::to_string(k);
    model += "  u" + n + ": {mass: 1, com: [" + n + ", 0.5, 0], inertia: [1/12, 1e-4, 1/12]}\n";
    if (k < loops)
      model += "  c" + n + ": {mass: 1, com: [" + n + ".5, 1, 0], inertia: [1e-4, 1/12, 1/12]}\n";
  }
  model += "joints:\n";
  for (int k = 0; k <= loops; ++k) {
    const std::string n = std::to_string(k), next = std::to_string(k + 1);
    model += "  A" + n + ": {type: revolute, between: [ground, u" + n + "], at: [" + n +
             ", 0, 0], axis: [0, 0, 1]" + (k == 0 ? ", velocity: -1" : "") + "}\n";
    if (k == loops) continue;
    model += "  B" + n + ": {type: revolute, between: [u" + n + ", c" + n + "], at: [" + n +
             ", 1, 0], axis: [0, 0, 1]}\n";
    model += "  C" + n + ": {type: revolute, between: [c" + n + ", u" + next + "], at: [" + next +
             ", 1, 0], axis: [0, 0, 1]}\n";
  }
  model += "outputs:\n  - {name: angle, joint: A0}\nsimulation: {step: 0.001, end: 10}\n";
  write_file(folder / "loops.yaml", model);
  for (const double step : {0.001, 0.00625}) {
    const auto json = run({"verify", "loops.yaml", "--step", std::to_string(step), "--json"}).json();
    // Whoever agrees moves as one loop does: the angle after 10 s of a run that is known to be right.
    const auto one = run({"run", "loops.yaml", "--step", "0.001", "--json"}).json();
    const auto seen = run({"run", "loops.yaml", "--step", std::to_string(step), "--json"});
    const bool right = seen.code == 0 && std::abs(seen.json().at("outputs").at("angle").number() -
                                                  one.at("outputs").at("angle").number()) < 0.1;
    EXPECT_TRUE(right || json.at("agree") == false) << step;
    EXPECT_TRUE(step > 0.001 || json.at("agree") == true);
  }
}

/// Loops, a flexible body, springs, a drive.
TEST_F(Verify, TheExamplesAgree) {
  const fs::path examples = fs::path(MIMBRE_SOURCE_DIR) / "examples";
  for (const char* example : {"bricard/mechanism.yaml", "tutorial/four-bar.yaml", "pendulum/flexible.yaml"}) {
    const Outcome outcome = run({"verify", (examples / example).string(), "--until", "1", "--json"});
    EXPECT_EQ(outcome.code, 0) << example << '\n' << outcome.err;
    EXPECT_EQ(outcome.json().at("agree"), true) << example;
  }
}

}  // namespace
}  // namespace mimbre::app_test::verify_test
