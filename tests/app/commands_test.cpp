#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "app/program.h"
#include "mimbre/report.h"
#include "support/text.h"

namespace mimbre::app_test::commands_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Commands : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_file(folder / "pendulum.yaml", pendulum);
  }
};

TEST_F(Commands, VersionIsTheProjects) {
  const std::string project = read_file(fs::path(MIMBRE_SOURCE_DIR) / "CMakeLists.txt");
  const auto version = test::matches(project, "project\\(mimbre VERSION ([0-9.]+)");
  ASSERT_EQ(version.size(), 1u);
  const Outcome outcome = run({"--version"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.out, "mimbre " + version[0][1] + "\n");
}

TEST_F(Commands, HelpGivesAnExample) {
  for (const char* command : {"run", "check", "static", "report", "compare", "bench", "verify"}) {
    EXPECT_THAT(run({"--help"}).out, HasSubstr(command));
    const Outcome outcome = run({command, "--help"});
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.err, "");
    EXPECT_THAT(outcome.out, HasSubstr(std::string("Example:\n  mimbre ") + command));
  }
}

/// A robot's model is written, and its conversion ends with the verdict of check.
TEST_F(Commands, ConvertEndsWithTheVerdictOfCheck) {
  const auto robot = [&](const char* mass) {
    write_file(folder / "robot.urdf",
               std::string("<robot name=\"r\"><link name=\"a\"/><link name=\"b\">") + mass +
                   "</link><joint name=\"j\" type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/>"
                   "<axis xyz=\"0 1 0\"/></joint></robot>");
    fs::remove(folder / "robot.yaml");
    return run({"convert", "robot.urdf"});
  };
  const Outcome sound = robot(
      "<inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" "
      "iyz=\"0\"/></inertial>");
  EXPECT_EQ(sound.code, 0) << sound.err;
  EXPECT_THAT(sound.err, Not(HasSubstr("refuses")));
  const Outcome empty = robot("");
  EXPECT_EQ(empty.code, 4);
  EXPECT_TRUE(fs::exists(folder / "robot.yaml"));
  EXPECT_THAT(empty.err, HasSubstr("robot.yaml is written, but `mimbre check` refuses it"));
  const Outcome check = run({"check", "robot.yaml"});
  EXPECT_EQ(check.code, 1);
  EXPECT_THAT(empty.err, HasSubstr(check.err));
}

TEST_F(Commands, WrongNamesAreAnsweredWithNearOnes) {
  const Outcome command = run({"chekc", "pendulum.yaml"});
  EXPECT_EQ(command.code, 2);
  EXPECT_THAT(command.err, HasSubstr("there is no command 'chekc' (did you mean 'check'?)"));
  const Outcome option = run({"run", "pendulum.yaml", "--outptu", "out.h5"});
  EXPECT_EQ(option.code, 2);
  EXPECT_THAT(option.err, HasSubstr("did you mean '--output'?"));
  const Outcome none = run({});
  EXPECT_EQ(none.code, 2);
  EXPECT_THAT(none.err, HasSubstr("Usage: mimbre"));
  EXPECT_EQ(none.out, "");
}

TEST_F(Commands, CheckCountsTheMotions) {
  // Two bars on ground hinges, joined by a third: a four-bar linkage with one degree of freedom.
  write_file(folder / "four-bar.yaml", R"(mimbre: 1
bodies:
  left: {mass: 1, com: [0, 0, 0.5], inertia: [0.1, 0.1, 0.1]}
  top: {mass: 2, com: [0.5, 0, 1], inertia: [0.1, 0.1, 0.1]}
  right: {mass: 3, com: [1, 0, 0.5], inertia: [0.1, 0.1, 0.1]}
joints:
  A: {type: revolute, between: [ground, left], at: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, between: [left, top], at: [0, 0, 1], axis: [0, 1, 0]}
  C: {type: revolute, between: [top, right], at: [1, 0, 1], axis: [0, 1, 0]}
  D: {type: revolute, between: [ground, right], at: [1, 0, 0], axis: [0, 1, 0], cut: always}
outputs:
  - {name: angle, joint: A}
)");
  const Outcome outcome = run({"check", "four-bar.yaml", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = outcome.json();
  ASSERT_EQ(json.at("bodies").size(), 3u);
  EXPECT_EQ(json.at("bodies")[1].at("name"), "top");
  EXPECT_EQ(json.at("bodies")[1].at("mass"), 2);
  EXPECT_NEAR(json.at("mass").number(), 6, 1e-12);
  EXPECT_EQ(json.at("coordinates"), 3);
  EXPECT_EQ(json.at("elastic_coordinates"), 0);
  EXPECT_EQ(json.at("constraints"), 5);
  EXPECT_EQ(json.at("degrees_of_freedom"), 1);
  EXPECT_EQ(json.at("loops"), 1);
  EXPECT_TRUE(json.at("warnings").is_array());
  ASSERT_EQ(json.at("joints").size(), 4u);
  for (const auto& joint : json.at("joints")) {
    EXPECT_EQ(joint.at("type"), "revolute");
    EXPECT_EQ(joint.at("cut"), joint.at("name") == "D");
  }
  const Outcome text = run({"check", "four-bar.yaml"});
  EXPECT_EQ(text.code, 0);
  EXPECT_THAT(text.out, HasSubstr("degrees of freedom     1\n"));
}

TEST_F(Commands, CheckTellsModesAndFrequencies) {
  // A clamped bar, whose first bending frequency is 1.8751²·sqrt(EI/(ρA L⁴))/2π.
  write_file(folder / "bar.yaml", R"(mimbre: 1
materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}
sections: {bar: {type: round, diameter: 0.02}}
bodies:
  bar:
    frame: {at: [0, 0, 0]}
    flexible:
      material: steel
      section: bar
      nodes: {root: [0, 0, 0], tip: [2, 0, 0]}
      bars: {only: {from: root, to: tip, elements: 10}}
      clamped: [root]
      dynamic_modes: 4
joints:
  foot: {type: fixed, between: [ground, bar], at: [0, 0, 0]}
outputs:
  - {name: tip, deflection: bar.tip, along: [0, 0, 1]}
)");
  const Outcome outcome = run({"check", "bar.yaml", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = outcome.json();
  EXPECT_EQ(json.at("elastic_coordinates"), 4);
  const double area = std::numbers::pi * 1e-4, inertia = std::numbers::pi * 1e-8 / 4;
  EXPECT_NEAR(json.at("mass").number(), 7850 * area * 2, 1e-6);
  const auto& body = json.at("bodies")[0];
  EXPECT_TRUE(body.at("flexible").boolean());
  const double omega = std::pow(1.8751041, 2) * std::sqrt(2.1e11 * inertia / (7850 * area * std::pow(2, 4)));
  const double hertz = omega / (2 * std::numbers::pi);
  EXPECT_NEAR(body.at("lowest_frequencies_hz")[0].number(), hertz, 1e-3 * hertz);
  const Outcome text = run({"check", "bar.yaml"});
  EXPECT_THAT(text.out, HasSubstr("flexible"));
}

TEST_F(Commands, StaticHangsThePendulumDown) {
  const Outcome outcome = run({"static", "pendulum.yaml", "--json", "--set", "length=2"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = outcome.json();
  EXPECT_NEAR(json.at("outputs").at("angle").number(), std::numbers::pi / 2, 1e-6);
  EXPECT_NEAR(json.at("outputs").at("bob.z").number(), -2, 1e-9);
  EXPECT_EQ(json.at("units").at("angle"), "rad");
  EXPECT_EQ(json.at("units").at("bob.z"), "m");
  EXPECT_FALSE(json.contains("angle")) << "each output stands once";
  EXPECT_GT(json.at("cpu_seconds"), 0);
  EXPECT_GE(json.at("iterations"), 1);
  const Outcome text = run({"static", "pendulum.yaml"});
  EXPECT_THAT(text.out, HasSubstr("-1.5  m"));
}

TEST_F(Commands, StaticFailsWhereThereIsNoEquilibrium) {
  write_file(folder / "falling.yaml",
             "mimbre: 1\nbodies:\n  stone: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}\n"
             "outputs:\n  - {name: z, position: stone, component: z}\n");
  const Outcome outcome = run({"static", "falling.yaml", "--json"});
  EXPECT_EQ(outcome.code, 3) << outcome.out;
  EXPECT_EQ(outcome.json().at("status"), "error");
  EXPECT_THAT(outcome.err, HasSubstr("equilibrium"));
  EXPECT_THAT(outcome.err, HasSubstr("body 'stone' floats freely"));
}

TEST_F(Commands, CompareFindsTheDifferencesOfTheTables) {
  ASSERT_EQ(run({"run", "pendulum.yaml", "--output", "a.h5", "--csv", "a.csv", "-q"}).code, 0);
  ASSERT_EQ(
      run({"run", "pendulum.yaml", "--set", "length=1.6", "--output", "b.h5", "--csv", "b.csv", "-q"}).code,
      0);
  const auto a = csv_rows(folder / "a.csv"), b = csv_rows(folder / "b.csv");
  ASSERT_EQ(a.size(), b.size());
  double largest = 0, amplitude = 0, sum = 0, at = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const double difference = std::abs(a[k][1] - b[k][1]);
    sum += difference;
    amplitude = std::max(amplitude, std::abs(a[k][1]));
    if (difference > largest) at = a[k][0];
    largest = std::max(largest, difference);
  }
  ASSERT_GT(largest, 0);

  const Outcome outcome = run({"compare", "a.h5", "b.h5", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto angle = outcome.json().at("channels").at("angle");
  EXPECT_EQ(angle.at("unit"), "rad");
  EXPECT_DOUBLE_EQ(angle.at("max_difference").number(), largest);
  EXPECT_NEAR(angle.at("mean_difference").number(), sum / static_cast<double>(a.size()), 1e-12);
  EXPECT_DOUBLE_EQ(angle.at("at_time").number(), at);
  EXPECT_DOUBLE_EQ(angle.at("relative").number(), largest / amplitude);
  EXPECT_EQ(run({"compare", "a.h5", "a.h5", "--json"}).json().at("channels").at("angle").at("max_difference"),
            0);
  EXPECT_THAT(run({"compare", "a.h5", "b.h5"}).out, HasSubstr("largest difference"));
  EXPECT_EQ(run({"compare", "a.h5", "pendulum.yaml"}).code, 1);
  EXPECT_EQ(run({"compare", "a.h5", "missing.h5"}).code, 1);
}

/// One motion, written at other instants: what is between them is interpolated, about as well as is said.
TEST_F(Commands, CompareInterpolatesBetweenInstants) {
  for (const char* interval : {"0.05", "0.03", "0.02"})
    ASSERT_EQ(run({"run", "pendulum.yaml", "-q", "--set", std::string("interval=") + interval, "-o",
                   std::string(interval) + ".h5"})
                  .code,
              0);
  const Outcome compared = run({"compare", "0.05.h5", "0.03.h5"});
  EXPECT_THAT(compared.out, HasSubstr("interpolation error"));
  EXPECT_THAT(compared.err, HasSubstr("note: some instants are not in both files"));
  const auto angle = run({"compare", "0.05.h5", "0.03.h5", "--json"}).json().at("channels").at("angle");
  EXPECT_LT(angle.at("max_difference").number(), angle.at("interpolation_error").number());
  EXPECT_LT(angle.at("max_difference").number(), 2e-5 * angle.at("amplitude").number());
  EXPECT_LT(angle.at("interpolation_error").number(), 1e-3 * angle.at("amplitude").number());
  ASSERT_EQ(run({"run", "pendulum.yaml", "-q", "-o", "all.h5"}).code, 0);
  const Outcome same = run({"compare", "0.05.h5", "all.h5"});
  EXPECT_THAT(same.out, Not(HasSubstr("interpolation error")));
  EXPECT_EQ(same.err, "");
}

/// A coordinate and its rate have no difference.
TEST_F(Commands, CompareLeavesOutWhatHasOtherUnits) {
  std::string rates = pendulum;
  rates.replace(rates.find("joint: hinge}"), 13, "joint_velocity: hinge}");
  write_file(folder / "rates.yaml", rates);
  ASSERT_EQ(run({"run", "pendulum.yaml", "--output", "a.h5", "-q"}).code, 0);
  ASSERT_EQ(run({"run", "rates.yaml", "--output", "b.h5", "-q"}).code, 0);
  const Outcome outcome = run({"compare", "a.h5", "b.h5"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("as their units in 'a.h5' and 'b.h5' differ: 'angle' (rad and rad/s)"));
  EXPECT_THAT(outcome.out, Not(HasSubstr("angle ")));
  EXPECT_EQ(run({"compare", "a.h5", "b.h5", "--strict"}).code, 4);
  EXPECT_EQ(run({"compare", "a.h5", "a.h5", "--strict"}).code, 0);
  EXPECT_FALSE(run({"compare", "a.h5", "b.h5", "--json"}).json().at("channels").contains("angle"));
}

/// The doors to a run find a channel by its name.
TEST_F(Commands, NoOutputIsCalledLikeAStandardChannel) {
  for (const char* name : {"energy.kinetic", "joint.hinge.position", "solver.iterations"}) {
    std::string text = pendulum;
    text.replace(text.find("name: angle"), 11, std::string("name: ") + name);
    write_file(folder / "taken.yaml", text);
    for (const char* command : {"run", "check", "static"}) {
      const Outcome outcome = run({command, "taken.yaml"});
      EXPECT_EQ(outcome.code, 1) << command;
      EXPECT_THAT(outcome.err, HasSubstr("taken.yaml:11:5: error: output '" + std::string(name) +
                                         "': every run of this model has a channel of that name"));
    }
  }
}

TEST_F(Commands, ReportMakesAPageWhereItIsBuiltIn) {
  ASSERT_EQ(run({"run", "pendulum.yaml", "--output", "a.h5", "-q"}).code, 0);
  const Outcome outcome = run({"report", "a.h5", "-o", "page.html"});
  if (report_available()) {
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, "page.html\n");
    EXPECT_THAT(read_file(folder / "page.html"), HasSubstr("A pendulum"));
    EXPECT_EQ(run({"report", "a.h5"}).out, "a.html\n");
    EXPECT_EQ(run({"report", "a.h5", "-o", "nowhere/page.html"}).code, 3);
  } else {
    EXPECT_EQ(outcome.code, 3);
    EXPECT_FALSE(fs::exists(folder / "page.html"));
  }
  EXPECT_EQ(run({"report", "missing.h5"}).code, 1);
  EXPECT_EQ(run({"report", "a.h5", "-o", "a.h5"}).code, 2);
}

TEST_F(Commands, ReportMakesAPageOfABody) {
  const std::string body = MIMBRE_SOURCE_DIR "/examples/solid-arm/arm.h5";
  const Outcome outcome = run({"report", body, "-o", "modes.html"});
  if (report_available()) {
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, "modes.html\n");
    EXPECT_THAT(read_file(folder / "modes.html"), HasSubstr("mimbre-modes-1"));
  } else {
    EXPECT_EQ(outcome.code, 3);
  }
  const Outcome two = run({"report", body, "a.h5", "-o", "page.html"});
  EXPECT_EQ(two.code, 2);
  EXPECT_THAT(two.err, HasSubstr("give the body alone"));
  EXPECT_EQ(run({"report", body, "--label", "arm"}).code, 2);
  EXPECT_EQ(run({"report", body, "-o", body}).code, 2);
}

TEST_F(Commands, BenchGivesMedians) {
  const Outcome table = run({"bench", "pendulum.yaml", "pendulum.yaml", "--runs", "2", "--until", "0.1"});
  ASSERT_EQ(table.code, 0) << table.err;
  EXPECT_THAT(table.out, HasSubstr("| model"));
  // Two tables of two models: whole runs, and where the time of a step goes.
  EXPECT_EQ(std::count(table.out.begin(), table.out.end(), '\n'), 9);
  EXPECT_THAT(table.out, HasSubstr("inverse dynamics"));

  const Outcome outcome = run({"bench", "pendulum.yaml", "--runs", "3", "--step", "0.005", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto measured = outcome.json().at("models")[0];
  EXPECT_EQ(measured.at("steps"), 200);
  std::vector<double> times = measured.at("cpu_seconds_of_runs").numbers();
  ASSERT_EQ(times.size(), 3u);
  std::sort(times.begin(), times.end());
  const double median = measured.at("cpu_seconds");
  EXPECT_EQ(median, times[1]);
  EXPECT_NEAR(measured.at("microseconds_per_step").number(), 1e6 * median / 200, 1e-6);
  EXPECT_NEAR(measured.at("real_time_factor").number(), 1 / median, 1e-6 / median);
  EXPECT_GE(measured.at("iterations_per_step"), 1);
  EXPECT_GT(measured.at("factorisations_per_step"), 0);
  EXPECT_LE(measured.at("factorisations_per_step"), measured.at("iterations_per_step").number());
  EXPECT_GT(measured.at("peak_memory_mb"), 1);
  double phases = 0;
  for (const test::Json& microseconds : measured.at("phases_microseconds_per_step"))
    phases += microseconds.number();
  EXPECT_GT(phases, 0);
  EXPECT_EQ(run({"bench", "pendulum.yaml", "--runs", "0"}).code, 2);
}

}  // namespace
}  // namespace mimbre::app_test::commands_test
