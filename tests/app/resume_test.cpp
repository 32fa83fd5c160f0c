#include <gmock/gmock.h>

#include "app/program.h"
#include "mimbre/results.h"

namespace mimbre::app_test::resume_test {
namespace {

using ::testing::HasSubstr;

/// Runs that were stopped and go on from a saved state.
class Resume : public ProgramTest {
 protected:
  using Arguments = std::vector<std::string>;

  void SetUp() override {
    ProgramTest::SetUp();
    write_file(folder / "pendulum.yaml", pendulum);
  }

  static Arguments with(Arguments arguments, const Arguments& more) {
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  /// Temporary files of that name: a run may be killed while it saves its state, too, whose temporary the
  /// next that saves there takes away.
  std::vector<std::string> left_over(const std::string& of) const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder))
      if (const std::string name = entry.path().filename().string();
          name.find(".part-") != std::string::npos && name.find(of) != std::string::npos)
        names.push_back(name);
    return names;
  }

  /// Kills a run and the ones that go on from it at random times until one comes to its end.
  int kills_until_the_end(const Arguments& run_arguments, int most, std::uint64_t seed) {
    std::uint64_t state = seed;
    int kills = 0;
    for (; kills < most; ++kills) {
      const bool begun = fs::exists(folder / "state");
      const pid_t child = start(with(run_arguments, begun ? Arguments{"--resume", "state"} : Arguments{}));
      EXPECT_TRUE(appears(folder / "state"));
      state = state * 6364136223846793005u + 1442695040888963407u;
      std::this_thread::sleep_for(std::chrono::milliseconds((state >> 33) % 120));
      kill(child, SIGKILL);
      const Outcome outcome = wait_for(child);
      if (outcome.signal != SIGKILL) {
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return kills;
      }
    }
    const Outcome last = run(with(run_arguments, {"--resume", "state"}));
    EXPECT_EQ(last.code, 0) << last.err;
    return kills;
  }
};

TEST_F(Resume, KilledTenTimesARunGivesTheSameFiles) {
  const Arguments run_arguments{"run",    "pendulum.yaml", "--until", "10000",
                                "--set",  "interval=0.5",  "--quiet", "-o",
                                "out.h5", "--csv",         "out.csv"};
  ASSERT_EQ(run(run_arguments).code, 0);
  fs::rename(folder / "out.h5", folder / "whole.h5");
  fs::rename(folder / "out.csv", folder / "whole.csv");
  const int kills =
      kills_until_the_end(with(run_arguments, {"--save-state", "state", "--every", "7.3"}), 10, 4711);
  EXPECT_GE(kills, 5);
  EXPECT_TRUE(read_file(folder / "out.h5") == read_file(folder / "whole.h5"));
  EXPECT_TRUE(read_file(folder / "out.csv") == read_file(folder / "whole.csv"));
}

/// Also where older files stand, which stay as they are until the end, and nothing is left beside.
TEST_F(Resume, TheTableAloneAndOlderFiles) {
  write_file(folder / "out.csv", "older");
  const Arguments run_arguments{"run",          "pendulum.yaml", "--until", "3000",    "--set",
                                "interval=0.2", "--csv",         "out.csv", "--quiet", "--csv-units"};
  ASSERT_EQ(run({"run", "pendulum.yaml", "--until", "3000", "--set", "interval=0.2", "--csv", "whole.csv",
                 "--quiet", "--csv-units"})
                .code,
            0);
  // On a busy machine the run may be over before it is killed.
  int signal = 0;
  for (int attempt = 0; attempt < 10 && signal != SIGKILL; ++attempt) {
    fs::remove(folder / "state");
    write_file(folder / "out.csv", "older");
    const pid_t child = start(with(run_arguments, {"--save-state", "state", "--every", "5"}));
    ASSERT_TRUE(appears(folder / "state"));
    kill(child, SIGKILL);
    signal = wait_for(child).signal;
  }
  ASSERT_EQ(signal, SIGKILL);
  EXPECT_EQ(read_file(folder / "out.csv"), "older");
  ASSERT_EQ(left_over("out.part-").size(), 1u);
  const Outcome on = run(with(run_arguments, {"--resume", "state"}));
  ASSERT_EQ(on.code, 0) << on.err;
  EXPECT_TRUE(read_file(folder / "out.csv") == read_file(folder / "whole.csv"));
  EXPECT_TRUE(left_over("out.part-").empty());
}

/// Runs that go on and are killed before they save again leave nothing when another comes to the end.
TEST_F(Resume, KilledBeforeItSavesAgain) {
  const auto until = [](const char* end, const Arguments& more) {
    return with({"run", "pendulum.yaml", "--until", end, "--csv", "out.csv", "--quiet"}, more);
  };
  ASSERT_EQ(run(until("50", {})).code, 0);
  const std::string whole = read_file(folder / "out.csv");
  for (const bool older : {false, true}) {
    SCOPED_TRACE(older);
    fs::remove(folder / "out.csv");
    const pid_t begun = start(until("1", {"--save-state", "state"}));
    ASSERT_EQ(wait_for(begun).code, 0);
    // As if it had been killed behind its saved state.
    fs::rename(folder / "out.csv", folder / ("out.part-" + std::to_string(begun) + ".csv"));
    if (older) write_file(folder / "out.csv", "older");
    for (int k = 0; k < 3; ++k) {
      const pid_t child = start(until("1e8", {"--resume", "state", "--every", "1e7"}));
      ASSERT_TRUE(appears(folder / ("out.part-" + std::to_string(child) + ".csv")));
      kill(child, SIGKILL);
      ASSERT_EQ(wait_for(child).signal, SIGKILL);
    }
    // As if it had been killed before its file had the mode of what grows.
    write_file(folder / ("out.part-" + std::to_string(begun) + "-1.csv"), "");
    EXPECT_EQ(left_over("out.part-").size(), 5u);
    const Outcome on = run(until("50", {"--resume", "state"}));
    ASSERT_EQ(on.code, 0) << on.err;
    EXPECT_TRUE(read_file(folder / "out.csv") == whole);
    EXPECT_TRUE(left_over("out.part-").empty());
  }
}

TEST_F(Resume, AnInterruptedRunSaysHowToGoOn) {
  const Arguments run_arguments{"run",    "pendulum.yaml", "--until", "3000",
                                "--set",  "interval=0.7",  "--quiet", "-o",
                                "out.h5", "--save-state",  "state"};
  ASSERT_EQ(
      run({"run", "pendulum.yaml", "--until", "3000", "--set", "interval=0.7", "--quiet", "-o", "whole.h5"})
          .code,
      0);
  // On a busy machine the run may be over before it is stopped.
  Outcome stopped;
  for (int attempt = 0; attempt < 10 && stopped.code != 3; ++attempt) {
    fs::remove(folder / "out.h5");
    const pid_t child = start(run_arguments);
    ASSERT_TRUE(appears(folder / "out.h5"));
    kill(child, SIGTERM);
    stopped = wait_for(child);
  }
  ASSERT_EQ(stopped.code, 3) << stopped.err;
  EXPECT_THAT(stopped.err, HasSubstr("; --resume state continues from there"));
  const Outcome on = run({"run", "pendulum.yaml", "--until", "3000", "--set", "interval=0.7", "--quiet", "-o",
                          "out.h5", "--resume", "state"});
  ASSERT_EQ(on.code, 0) << on.err;
  EXPECT_TRUE(read_file(folder / "out.h5") == read_file(folder / "whole.h5"));
}

TEST_F(Resume, ARunGoesOnBeyondItsEnd) {
  ASSERT_EQ(run({"run", "pendulum.yaml", "--until", "2", "-o", "whole.h5"}).code, 0);
  ASSERT_EQ(run({"run", "pendulum.yaml", "--until", "1", "-o", "out.h5", "--save-state", "state"}).code, 0);
  ASSERT_EQ(run({"run", "pendulum.yaml", "--until", "2", "-o", "on.h5", "--resume", "state"}).code, 0);
  const Results whole = read_results((folder / "whole.h5").string()),
                on = read_results((folder / "on.h5").string());
  EXPECT_TRUE(whole.time == on.time);
  EXPECT_TRUE(whole.channels == on.channels);
  EXPECT_EQ(whole.summary_json, on.summary_json);
}

/// While an older file stands, the rows grow in another, which takes its name at the end.
TEST_F(Resume, ARunThatReplacedAnOlderFileGoesOnIntoAnother) {
  const Arguments first{"run", "pendulum.yaml", "--until", "1", "--quiet", "--save-state", "state"},
      on{"run", "pendulum.yaml", "--until", "2", "--quiet", "--resume", "state"};
  ASSERT_EQ(run({"run", "pendulum.yaml", "--until", "2", "--quiet", "--csv", "whole.csv"}).code, 0);
  for (const std::string option : {"--csv", "-o"}) {
    SCOPED_TRACE(option);
    const std::string end = option == "-o" ? ".h5" : ".csv";
    fs::remove(folder / "state");
    for (int k = 0; k < 2; ++k) {
      const Outcome begun = run(with(first, {option, "out" + end}));
      ASSERT_EQ(begun.code, 0) << begun.err;
    }
    const Outcome resumed = run(with(on, {option, "on" + end}));
    ASSERT_EQ(resumed.code, 0) << resumed.err;
    EXPECT_TRUE(left_over("out.part-").empty());
    fs::rename(folder / ("out" + end), folder / ("away" + end));
    const Outcome lost = run(with(on, {option, "on-again" + end}));
    EXPECT_EQ(lost.code, 1);
    EXPECT_THAT(lost.err, HasSubstr("/out" + end + ": error: the "));
    EXPECT_THAT(lost.err, HasSubstr("are neither here nor in "));
  }
  EXPECT_TRUE(read_file(folder / "on.csv") == read_file(folder / "whole.csv"));
}

/// The old end is no row of the longer run, unless it is on the output interval.
TEST_F(Resume, TheRowOfAnEarlierEndGoes) {
  const Arguments run_arguments{"run", "pendulum.yaml", "--set", "interval=0.05", "--quiet"};
  ASSERT_EQ(run(with(run_arguments, {"-o", "whole.h5", "--csv", "whole.csv"})).code, 0);
  for (const char* const end : {"0.07", "0.1"}) {
    SCOPED_TRACE(end);
    const Arguments files{"-o", "out.h5", "--csv", "out.csv"},
        begun = with(run_arguments, {"--until", end, "--save-state", "state"});
    ASSERT_EQ(run(with(begun, files)).code, 0);
    EXPECT_EQ(csv_rows(folder / "out.csv").size(), 3u);
    ASSERT_EQ(run(with(with(run_arguments, files), {"--resume", "state"})).code, 0);
    EXPECT_TRUE(read_file(folder / "out.h5") == read_file(folder / "whole.h5"));
    EXPECT_TRUE(read_file(folder / "out.csv") == read_file(folder / "whole.csv"));
    // Of the table alone, and from one earlier end to the next.
    ASSERT_EQ(run(with(begun, {"--csv", "on.csv"})).code, 0);
    for (const char* const later : {"0.08", "0.12", "0.13"})
      if (std::strtod(later, nullptr) > std::strtod(end, nullptr)) {
        ASSERT_EQ(run(with(run_arguments, {"--csv", "on.csv", "--until", later, "--resume", "state",
                                           "--save-state", "state"}))
                      .code,
                  0);
      }
    ASSERT_EQ(run(with(run_arguments, {"--csv", "on.csv", "--resume", "state"})).code, 0);
    EXPECT_TRUE(read_file(folder / "on.csv") == read_file(folder / "whole.csv"));
  }
}

/// Where an event stops a run, within a step or at its end, is one row, and the end of the resumed run, too.
TEST_F(Resume, ARunThatAnEventStoppedStaysStopped) {
  const std::string model = std::string(pendulum) + "\n";
  for (const char* const when : {"t - 0.0404", "t - 0.04", "t - 0.04000000001"})
    for (const bool fixed_cost : {false, true}) {
      SCOPED_TRACE(std::string(when) + (fixed_cost ? ", fixed cost" : ""));
      write_file(folder / "stops.yaml", model + "events: {late: {when: \"" + when + "\", stop: true}}\n");
      const Arguments cost = fixed_cost ? Arguments{"--fixed-cost"} : Arguments{},
                      run_arguments =
                          with({"run", "stops.yaml", "--quiet", "--save-state", "state", "--csv", "out.csv"},
                               cost);
      for (const bool results : {false, true}) {
        const Arguments begun = with(run_arguments, results ? Arguments{"-o", "out.h5"} : Arguments{});
        ASSERT_EQ(run(begun).code, 0);
        const auto rows = csv_rows(folder / "out.csv");
        ASSERT_GE(rows.size(), 5u);
        EXPECT_LT(rows[rows.size() - 2][0], rows.back()[0]);
        EXPECT_LE(rows.back()[0], fixed_cost ? 0.0501 : 0.0405);
        const std::string table = read_file(folder / "out.csv"),
                          bytes = results ? read_file(folder / "out.h5") : "";
        if (results) {
          EXPECT_EQ(read_results((folder / "out.h5").string()).time.size(), std::ssize(rows));
        }
        // Again, and beyond the end that it had.
        for (const Arguments& more : {Arguments{}, Arguments{}, Arguments{"--until", "3"}}) {
          ASSERT_EQ(run(with(with(begun, {"--resume", "state"}), more)).code, 0);
          EXPECT_EQ(read_file(folder / "out.csv"), table);
          if (results && more.empty()) {
            EXPECT_TRUE(read_file(folder / "out.h5") == bytes);
          }
        }
        EXPECT_EQ(run(with(begun, {"--resume", "state", "--until", "0.02"})).code, 2);
      }
    }
  ASSERT_EQ(run({"run", "stops.yaml", "-q", "--save-state", "state"}).code, 0);
  EXPECT_THAT(run({"run", "stops.yaml", "--resume", "state"}).err,
              HasSubstr("note: an event stopped the saved run at t = 0.04 s: it ends there"));
}

TEST_F(Resume, WhatDoesNotFitIsSaid) {
  const auto fails = [&](const Arguments& arguments, int code, const std::string& message) {
    const Outcome outcome = run(with({"run"}, arguments));
    EXPECT_EQ(outcome.code, code);
    EXPECT_THAT(outcome.err, HasSubstr(message));
  };
  ASSERT_EQ(run({"run", "pendulum.yaml", "-o", "out.h5", "--save-state", "state", "--every", "0.5"}).code, 0);
  const Arguments on{"pendulum.yaml", "-o", "out.h5", "--resume", "state"};
  fails({"pendulum.yaml", "--every", "1"}, 2, "--every belongs to --save-state FILE");
  fails({"pendulum.yaml", "--resume", "none"}, 1, "none: error: cannot be read");
  fails({"pendulum.yaml", "--resume", "pendulum.yaml"}, 1, "not a saved state of a run");
  fails(with(on, {"--step", "0.005"}), 2, "they differ in 'step'");
  fails(with(on, {"--set", "length=2"}), 2, "they differ in 'set'");
  fails(with(on, {"--until", "0.5"}), 2, "is at t = 1 s already, the end asked for is 0.5 s");
  fails({"pendulum.yaml", "--resume", "state"}, 2, "the saved run had --output; give it here as well");
  fails(with(on, {"--csv", "out.csv"}), 2, "the saved run had no --csv");
  fails({"pendulum.yaml", "-o", "state", "--resume", "state"}, 2, "would be overwritten");
  fs::rename(folder / "out.h5", folder / "away.h5");
  fails(with(on, {"--until", "2"}), 1,
        "the 101 rows that the saved run had recorded until t = 1 s are no longer here; put that file back");
  EXPECT_FALSE(fs::exists(folder / "out.h5"));
  fs::rename(folder / "away.h5", folder / "out.h5");

  std::string changed = pendulum;
  changed.replace(changed.find("mass: 2"), 7, "mass: 3");
  write_file(folder / "pendulum.yaml", changed);
  fails(on, 1, "pendulum.yaml: error: the state in 'state' was saved of another model, or the model");
  write_file(folder / "pendulum.yaml", pendulum);
  ASSERT_EQ(run(with({"run"}, on)).code, 0);

  const std::string whole = read_file(folder / "state");
  for (const std::size_t at : {std::size_t{30}, whole.size() / 2, whole.size() - 3}) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 4);
    write_file(folder / "state", damaged);
    fails(on, 1, "is damaged");
    write_file(folder / "state", whole.substr(0, at));
    fails(on, 1, "is damaged");
  }
  std::string later = whole;
  later[19] = '9';
  write_file(folder / "state", later);
  fails(on, 1, "has layout 'mimbre-run-state-009', this version of mimbre reads 'mimbre-run-state-004'");
}

/// A table is what it holds, whatever its file is called.
TEST_F(Resume, TablesOfInputsAreThoseOfTheSavedRun) {
  write_file(folder / "push.yaml", pendulum +
                                       "inputs: {torque: {start: 0}}\nactuators: {a: {joint: hinge, "
                                       "torque: torque}}\n");
  const auto table = [&](const char* name, const char* value) {
    write_file(folder / name, std::string("t,torque\n0,0\n0.3,") + value + "\n");
  };
  const auto on = [&](const Arguments& more) {
    return run(with({"run", "push.yaml", "-q", "-o", "on.h5", "--resume", "state"}, more));
  };
  table("given.csv", "1");
  table("same.csv", "1.0");
  table("other.csv", "9");
  ASSERT_EQ(run({"run", "push.yaml", "-q", "--input", "given.csv", "-o", "whole.h5"}).code, 0);
  ASSERT_EQ(run({"run", "push.yaml", "-q", "--input", "given.csv", "-o", "out.h5", "--until", "0.5",
                 "--save-state", "state"})
                .code,
            0);
  const Outcome other = on({"--input", "other.csv"});
  EXPECT_EQ(other.code, 1);
  EXPECT_THAT(other.err, HasSubstr("other.csv: error: the table of input 'torque' is not the one that the "
                                   "saved run played"));
  EXPECT_EQ(on({}).code, 2);
  table("given.csv", "9");
  EXPECT_EQ(on({"--input", "given.csv"}).code, 1);
  EXPECT_FALSE(fs::exists(folder / "on.h5"));
  ASSERT_EQ(on({"--input", "torque=same.csv"}).code, 0);
  EXPECT_TRUE(read_results((folder / "on.h5").string()).channels ==
              read_results((folder / "whole.h5").string()).channels);
}

/// What was taken is said once for all: in the summary, the results file and by check.
TEST_F(Resume, ARunSaysWhatItTook) {
  std::string endless = pendulum;
  endless.replace(endless.find(", end: 1"), 8, "");
  write_file(folder / "endless.yaml", endless);
  const Outcome by_default = run({"run", "endless.yaml", "--json", "-o", "out.h5"});
  ASSERT_EQ(by_default.code, 0);
  EXPECT_THAT(by_default.err, HasSubstr("the model has no end: the run ends at 10 s"));
  const auto resolved = by_default.json().at("resolved");
  EXPECT_TRUE(resolved.at("default_end").boolean());
  EXPECT_EQ(resolved.at("end").number(), 10);
  EXPECT_EQ(resolved.at("substeps").number(), 4);
  EXPECT_EQ(resolved.at("output_interval").number(), 0.01);
  const Results results = read_results((folder / "out.h5").string());
  EXPECT_EQ(test::Json::parse(results.summary_json).at("resolved").at("end").number(), 10);
  const Outcome check = run({"check", "endless.yaml", "--json"});
  EXPECT_TRUE(check.json().at("resolved").at("default_end").boolean());
  EXPECT_THAT(run({"check", "endless.yaml"}).out, HasSubstr("s (the default)"));
  const Outcome given = run({"run", "endless.yaml", "--until", "1", "--json"});
  EXPECT_EQ(given.err, "");
  EXPECT_FALSE(given.json().at("resolved").at("default_end").boolean());
}

}  // namespace
}  // namespace mimbre::app_test::resume_test
