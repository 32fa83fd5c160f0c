#include <gmock/gmock.h>

#include <cmath>

#include "app/program.h"
#include "mimbre/results.h"

namespace mimbre::app_test::run_test {
namespace {

using ::testing::HasSubstr;

class RunCommand : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_file(folder / "pendulum.yaml", pendulum);
  }
};

TEST_F(RunCommand, SummarisesInATableOrAsJson) {
  const Outcome table = run({"run", "pendulum.yaml"});
  EXPECT_EQ(table.code, 0);
  EXPECT_EQ(table.err, "");
  EXPECT_THAT(table.out, HasSubstr("real-time factor"));
  EXPECT_EQ(run({"run", "pendulum.yaml", "--quiet"}).err, "");

  const Outcome outcome = run({"run", "pendulum.yaml", "--json"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.err, "");
  const auto json = outcome.json();
  EXPECT_EQ(json.at("status"), "ok");
  EXPECT_EQ(json.at("steps"), 100);
  EXPECT_EQ(json.at("step"), 0.01);
  EXPECT_NEAR(json.at("time").number(), 1, 1e-9);
  EXPECT_EQ(json.at("coordinates"), 1);
  EXPECT_GE(json.at("iterations"), 100);
  EXPECT_DOUBLE_EQ(json.at("iterations_per_step").number(), json.at("iterations").number() / 100);
  EXPECT_GE(json.at("factorisations"), 1);
  EXPECT_GT(json.at("cpu_seconds"), 0);
  EXPECT_GT(json.at("initialisation_seconds"), 0);
  EXPECT_NEAR(json.at("real_time_factor").number() * json.at("cpu_seconds").number(), 1, 1e-9);
  EXPECT_EQ(json.at("max_position_violation"), 0);
  EXPECT_EQ(json.at("max_velocity_violation"), 0);
  EXPECT_TRUE(json.at("warnings").empty());
  EXPECT_GT(json.at("peak_memory_mb"), 1);
  for (const char* name : {"kinetic", "gravitational", "elastic", "springs", "tyres", "dissipated",
                           "drive_work", "load_work", "road_work", "numerical"})
    EXPECT_TRUE(json.at("energy").at(name).is_number()) << name;
  // The bob is where the hinge's angle puts it.
  const auto& outputs = json.at("outputs");
  EXPECT_NEAR(outputs.at("bob.z").number(), -1.5 * std::sin(outputs.at("angle").number()), 1e-9);
}

TEST_F(RunCommand, WritesTheOutputsAsColumns) {
  ASSERT_EQ(run({"run", "pendulum.yaml", "--csv", "out.csv", "--set", "interval=0.05"}).code, 0);
  const std::string text = read_file(folder / "out.csv");
  EXPECT_EQ(text.substr(0, text.find('\n')), "t,angle,bob.z");
  for (const auto& entry : fs::directory_iterator(folder))
    EXPECT_EQ(entry.path().string().find(".part-"), std::string::npos);
  const auto rows = csv_rows(folder / "out.csv");
  ASSERT_EQ(rows.size(), 21u);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    ASSERT_EQ(rows[k].size(), 3u);
    EXPECT_NEAR(rows[k][0], 0.05 * static_cast<double>(k), 1e-9);
    EXPECT_NEAR(rows[k][2], -1.5 * std::sin(rows[k][1]), 1e-9);
  }
}

TEST_F(RunCommand, WritesResultsWithTheCommandLineAndTheSummary) {
  const Outcome outcome =
      run({"run", "pendulum.yaml", "--output", "out.h5", "--csv", "out.csv", "--set", "length=2", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Results results = read_results((folder / "out.h5").string());
  EXPECT_EQ(results.header.title, "A pendulum");
  EXPECT_EQ(results.header.model_text, pendulum);
  EXPECT_EQ(test::Json::parse(results.header.options_json).at("set").at("length"), "2");
  const auto rows = csv_rows(folder / "out.csv");
  ASSERT_EQ(results.time.size(), static_cast<Eigen::Index>(rows.size()));
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    EXPECT_EQ(results.time[i], rows[k][0]);
    EXPECT_EQ(results.channels(i, 0), rows[k][1]);
    EXPECT_EQ(results.channels(i, 1), rows[k][2]);
  }
  // The file's summary is the printed one without what differs from run to run.
  auto printed = outcome.json();
  const auto kept = test::Json::parse(results.summary_json);
  for (const char* name : {"cpu_seconds", "initialisation_seconds", "real_time_factor", "peak_memory_mb",
                           "build", "command", "units"})
    printed = printed.without(name);
  EXPECT_EQ(printed, kept);
}

TEST_F(RunCommand, TheSameRunGivesTheSameBytes) {
  ASSERT_EQ(run({"run", "pendulum.yaml", "--output", "a.h5", "--csv", "a.csv"}).code, 0);
  ASSERT_EQ(run({"run", "pendulum.yaml", "--output", "b.h5", "--csv", "b.csv", "--json"}).code, 0);
  EXPECT_FALSE(read_file(folder / "a.h5").empty());
  EXPECT_TRUE(read_file(folder / "a.h5") == read_file(folder / "b.h5"));
  EXPECT_EQ(read_file(folder / "a.csv"), read_file(folder / "b.csv"));
}

TEST_F(RunCommand, StepAndEndOfTheCommandLineCount) {
  const auto json =
      run({"run", "pendulum.yaml", "--until", "0.5", "--step", "0.005", "--csv", "out.csv", "--json"}).json();
  EXPECT_EQ(json.at("steps"), 100);
  EXPECT_EQ(json.at("step"), 0.005);
  EXPECT_NEAR(json.at("time").number(), 0.5, 1e-9);
  // The output interval of 0.01 s is two of these steps.
  EXPECT_EQ(csv_rows(folder / "out.csv").size(), 51u);
  EXPECT_EQ(run({"run", "pendulum.yaml", "--until", "0", "--json"}).json().at("steps"), 0);
}

TEST_F(RunCommand, EndsAtItsEndWithTheRowOfItsSummary) {
  const std::vector<std::pair<const char*, const char*>> runs{
      {"0.3", "1"}, {"0.005", "0.025"}, {"0.004", "0.05"}, {"0.007", "0.02"}};
  for (const auto& [step, until] : runs) {
    const Outcome outcome = run({"run", "pendulum.yaml", "--step", step, "--until", until, "--csv", "out.csv",
                                 "--output", "out.h5", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const double end = std::stod(until);
    const auto rows = csv_rows(folder / "out.csv");
    const Results results = read_results(folder / "out.h5");
    EXPECT_EQ(outcome.json().at("time").number(), end);
    EXPECT_EQ(rows.back()[0], end);
    EXPECT_EQ(results.time[results.time.size() - 1], end);
    EXPECT_EQ(static_cast<std::size_t>(results.time.size()), rows.size());
    EXPECT_EQ(rows.back()[1], outcome.json().at("outputs").at("angle").number());
  }
  ASSERT_EQ(run({"run", "pendulum.yaml", "--step", "0.004", "--until", "0.05", "--csv", "out.csv"}).code, 0);
  const auto rows = csv_rows(folder / "out.csv");
  const std::vector<double> times{0, 0.012, 0.02, 0.032, 0.04, 0.05};
  ASSERT_EQ(rows.size(), times.size());
  for (std::size_t k = 0; k < times.size(); ++k) EXPECT_NEAR(rows[k][0], times[k], 1e-12);
}

TEST_F(RunCommand, AStepLongerThanTheRunIsRefused) {
  for (const char* command : {"run", "verify", "bench"}) {
    const Outcome outcome = run({command, "pendulum.yaml", "--step", "10", "--until", "1"});
    EXPECT_EQ(outcome.code, 2) << command;
    EXPECT_THAT(outcome.err, HasSubstr("the step of 10 s is longer than the run"));
    EXPECT_EQ(outcome.out, "");
  }
}

/// A wall hit at 5 m/s: the steps of the impact are made again in parts, and counted.
TEST_F(RunCommand, RepeatedStepsAreCounted) {
  write_file(folder / "impact.yaml", R"(mimbre: 1
gravity: [0, 0, 0]
bodies:
  ball: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}
joints:
  slide:
    type: prismatic
    between: [ground, ball]
    at: [0, 0, 0]
    axis: [1, 0, 0]
    velocity: 5
    spring: {elastic: {pieces: [{until: 1, polynomial: [0]}, {polynomial: [-1e6, 1e6]}]}}
outputs:
  - {name: x, joint: slide}
simulation: {step: 0.01, end: 0.4}
)");
  const Outcome outcome = run({"run", "impact.yaml", "--output", "out.h5", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_GE(outcome.json().at("repeated_steps"), 1);
  EXPECT_LE(outcome.json().at("repeated_steps"), 4);
  EXPECT_THAT(read_results(folder / "out.h5").summary_json, HasSubstr("\"repeated_steps\""));
  EXPECT_THAT(run({"run", "impact.yaml"}).out, HasSubstr("steps repeated in parts"));
  EXPECT_EQ(run({"run", "pendulum.yaml", "--json"}).json().at("repeated_steps"), 0);
}

/// A warning is an exit code with --strict, and only then.
TEST_F(RunCommand, StrictlyAWarningIsAnExitCode) {
  std::string model = pendulum;
  model.erase(model.find("outputs:"), model.find("simulation:") - model.find("outputs:"));
  write_file(folder / "silent.yaml", model);  // warned of: it has no outputs
  for (const char* command : {"run", "check", "verify", "static"}) {
    EXPECT_EQ(run({command, "silent.yaml"}).code, 0) << command;
    EXPECT_EQ(run({command, "silent.yaml", "--strict"}).code, 4) << command;
    EXPECT_EQ(run({command, "pendulum.yaml", "--strict"}).code, 0) << command;
    EXPECT_EQ(run({command, "missing.yaml", "--strict"}).code, 1) << command;
  }
}

TEST_F(RunCommand, SetReplacesAParameter) {
  const auto json =
      run({"run", "pendulum.yaml", "--set", "length=3", "--set", "interval=0.1", "--json"}).json();
  const auto& outputs = json.at("outputs");
  EXPECT_NEAR(outputs.at("bob.z").number(), -3 * std::sin(outputs.at("angle").number()), 1e-9);
}

TEST_F(RunCommand, IntegratorsOfTheCommandLineDamp) {
  // A negative xi and a small rho take energy out; the trapezoidal rule hardly does.
  const auto numerical = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(),
                     {"run", "pendulum.yaml", "--step", "0.05", "--until", "10", "--json"});
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.json().at("energy").at("numerical").number();
  };
  const double trapezoidal = numerical({"--integrator-xi", "0"});
  EXPECT_LT(numerical({"--integrator-xi", "-0.3"}), trapezoidal - 0.1);
  EXPECT_LT(numerical({"--integrator-xi=-0.3"}), trapezoidal - 0.1);
  EXPECT_LT(numerical({"--rho", "0"}), numerical({"--rho", "0.9"}));
  EXPECT_EQ(run({"run", "pendulum.yaml", "--rho", "0.5", "--integrator-xi", "0"}).code, 2);
}

TEST_F(RunCommand, BadInputMakesNoFiles) {
  write_file(folder / "bad.yaml",
             "mimbre: 1\nbodies:\n  bob: {mass: -2}\nsimulation: {step: 0.01, end: 1, stp: 2}\n");
  const Outcome outcome = run({"run", "bad.yaml", "--output", "out.h5", "--csv", "out.csv", "--json"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("bad.yaml:3:"));
  EXPECT_THAT(outcome.err, HasSubstr(": error: "));
  const auto json = outcome.json();
  EXPECT_EQ(json.at("status"), "error");
  EXPECT_GE(json.at("errors").size(), 2u);
  EXPECT_EQ(json.at("errors")[0].at("file"), "bad.yaml");
  EXPECT_GE(json.at("errors")[0].at("line"), 1);
  EXPECT_TRUE(json.at("errors")[0].at("message").is_string());
  EXPECT_FALSE(fs::exists(folder / "out.h5"));
  EXPECT_FALSE(fs::exists(folder / "out.csv"));
  for (const auto& entry : fs::directory_iterator(folder))
    EXPECT_EQ(entry.path().string().find(".part-"), std::string::npos);
}

TEST_F(RunCommand, UnknownParametersAreNamed) {
  const Outcome outcome = run({"run", "pendulum.yaml", "--set", "lenght=2", "--output", "out.h5"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("'lenght'"));
  EXPECT_THAT(outcome.err, HasSubstr("did you mean 'length'?"));
  EXPECT_FALSE(fs::exists(folder / "out.h5"));
}

TEST_F(RunCommand, WrongUseIsToldApart) {
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"run"},
                                                    {"run", "pendulum.yaml", "--set", "length"},
                                                    {"run", "pendulum.yaml", "--set", "=2"},
                                                    {"run", "pendulum.yaml", "--step", "0"},
                                                    {"run", "pendulum.yaml", "--step", "nan"},
                                                    {"run", "pendulum.yaml", "--until", "-1"},
                                                    {"run", "pendulum.yaml", "--until", "inf"},
                                                    {"run", "pendulum.yaml", "--rho", "nan"},
                                                    {"run", "pendulum.yaml", "--rho", "2"},
                                                    {"run", "pendulum.yaml", "--integrator-xi", "0.1"},
                                                    {"run", "pendulum.yaml", "more.yaml"}}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments.back() << '\n' << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("error: "));
    EXPECT_EQ(outcome.out, "");
  }
}

TEST_F(RunCommand, OutputsNeverReplaceTheModel) {
  EXPECT_EQ(run({"run", "pendulum.yaml", "--output", "./pendulum.yaml"}).code, 2);
  EXPECT_EQ(run({"run", "pendulum.yaml", "--csv", "pendulum.yaml"}).code, 2);
  EXPECT_EQ(run({"run", "pendulum.yaml", "--csv", "out", "--output", "out"}).code, 2);
  EXPECT_EQ(read_file(folder / "pendulum.yaml"), pendulum);
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST_F(RunCommand, FilesThatCannotBeOpenedAreNamed) {
  for (const char* option : {"--output", "--csv"})
    for (const char* path : {"nowhere/out", "."}) {
      const Outcome outcome = run({"run", "pendulum.yaml", option, path});
      EXPECT_EQ(outcome.code, 3) << outcome.err;
      EXPECT_THAT(outcome.err, HasSubstr(path));
    }
  // One that cannot be opened does not spoil the other.
  write_file(folder / "old.h5", "old");
  EXPECT_EQ(run({"run", "pendulum.yaml", "--output", "old.h5", "--csv", "nowhere/out.csv"}).code, 3);
  EXPECT_EQ(read_file(folder / "old.h5"), "old");
}

TEST_F(RunCommand, TooManyStepsAreRefused) {
  const Outcome outcome = run({"run", "pendulum.yaml", "--until", "1e300", "--step", "1e-9"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("too many steps"));
}

TEST_F(RunCommand, AFailingStepSaysWhereAndKeepsTheResults) {
  // The load's law is not a number beyond t = 0.5 s.
  std::string model = pendulum;
  model.insert(model.find("outputs:"),
               "loads:\n  push: {on: bob, at: [length, 0, 0], force: [0, 0, 1], scale: sqrt(0.5001-t)}\n");
  write_file(folder / "failing.yaml", model);
  const Outcome outcome = run({"run", "failing.yaml", "--output", "out.h5", "--csv", "out.csv", "--json"});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("t = 0.51 s"));
  EXPECT_THAT(outcome.err, HasSubstr("hinge"));
  const auto json = outcome.json();
  EXPECT_EQ(json.at("status"), "failed");
  EXPECT_THAT(outcome.err, HasSubstr(json.at("message").text()));
  EXPECT_EQ(json.at("steps"), 50);
  const Results results = read_results((folder / "out.h5").string());
  EXPECT_EQ(results.time.size(), 51);
  EXPECT_TRUE(results.channels.allFinite());
  EXPECT_EQ(test::Json::parse(results.summary_json).at("status"), "failed");
  EXPECT_EQ(csv_rows(folder / "out.csv").size(), 51u);
}

TEST_F(RunCommand, WarningsOfTheModelAreToldOnce) {
  std::string model = pendulum;
  model.insert(model.find("outputs:"), "roads:\n  detour: {over: distance, points: [[0, 0], [5, 0]]}\n");
  write_file(folder / "suspicious.yaml", model);
  const Outcome outcome = run({"run", "suspicious.yaml", "--json"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const auto warnings = outcome.json().at("warnings");
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0].text(), HasSubstr("detour"));
  EXPECT_THAT(outcome.err, HasSubstr(": warning: "));
  EXPECT_EQ(outcome.err.find("detour"), outcome.err.rfind("detour"));
}

/// One table for all inputs is the same as one for each; what is cut to a range is said.
TEST_F(RunCommand, PlaysRecordedInputs) {
  write_file(folder / "motor.yaml", R"(mimbre: 1
inputs: {u: {start: 0, range: [-5, 5], unit: N m}, w: {start: 0, hold: linear}}
bodies: {b: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {j: {type: revolute, between: [ground, b], at: [0, 0, 0], axis: [0, 0, 1]}}
actuators: {m: {joint: j, torque: u + w}}
outputs: [{name: angle, joint: j}]
simulation: {step: 0.01, end: 1}
)");
  write_file(folder / "all.csv", "w,t [s],u [N m]\r\n0,0,1\r\n,0.5,12\r\n4,1,\r\n");
  write_file(folder / "u.csv", "value;time\n1;0\n12;0,5\n");
  write_file(folder / "w.csv", "0,0\n1,4\n");
  const auto all = run({"run", "motor.yaml", "--input", "all.csv", "--json"}),
             each = run({"run", "motor.yaml", "--input", "u=u.csv", "--input", "w=w.csv", "--json"});
  ASSERT_EQ(all.code, 0) << all.err;
  ASSERT_EQ(each.code, 0) << each.err;
  EXPECT_EQ(all.json().at("outputs"), each.json().at("outputs"));
  // 1 N m for 0.5 s, then 5, and 4 t: exact but for the straight lines of the steps.
  EXPECT_NEAR(all.json().at("outputs").at("angle").number(), 0.5 * 1 + 0.5 * 4 * 0.25 + 4. / 6, 2e-2);
  ASSERT_EQ(all.json().at("warnings").size(), 1u);
  EXPECT_THAT(all.err,
              HasSubstr("input 'u': 1 value was beyond its range [-5, 5] and cut to it, the first at "
                        "t = 0.5 s; the farthest was 12"));
  EXPECT_EQ(run({"run", "motor.yaml", "--input", "all.csv", "--strict", "-q"}).code, 4);

  write_file(folder / "bad.csv", "t,u\n0,nan\n");
  const Outcome bad = run({"run", "motor.yaml", "--input", "u=bad.csv"});
  EXPECT_EQ(bad.code, 1);
  EXPECT_THAT(bad.err, HasSubstr("bad.csv:2:1: error: the value of 'u': 'nan' is not a finite number"));
  EXPECT_EQ(run({"run", "motor.yaml", "--input", "v=all.csv"}).code, 1);
  EXPECT_EQ(run({"run", "motor.yaml", "--input", "u=u.csv", "--input", "all.csv"}).code, 2);
  EXPECT_EQ(run({"run", "motor.yaml", "--input", "=u.csv"}).code, 2);
  EXPECT_EQ(run({"live", "motor.yaml", "--input", "u=bad.csv", "--no-open"}).code, 1);
}

TEST_F(RunCommand, AnEmptyTokenIsNone) {
  const Outcome outcome = run({"live", "pendulum.yaml", "--token", "", "--no-open"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("--token: the token is empty"));
}

}  // namespace
}  // namespace mimbre::app_test::run_test
