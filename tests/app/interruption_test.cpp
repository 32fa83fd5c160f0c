#include <gmock/gmock.h>

#include <sys/stat.h>

#include <algorithm>
#include <iostream>

#include "app/program.h"
#include "mimbre/results.h"
#include "support/clocked.h"

namespace mimbre::app_test::interruption_test {
namespace {

using ::testing::HasSubstr;

/// Runs that do not come to their end.
class Interruption : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_file(folder / "pendulum.yaml", pendulum);
  }

  /// The files in the folder whose names begin and end so.
  std::vector<fs::path> files(const std::string& begin, const std::string& end) const {
    std::vector<fs::path> result;
    for (const auto& entry : fs::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with(begin) && name.ends_with(end)) result.push_back(entry.path());
    }
    return result;
  }

  /// An empty folder for the k-th of several programs at once.
  fs::path place_of(int k) const { return folder / ("place-" + std::to_string(k)); }
  fs::path own_place(int k) const {
    fs::remove_all(place_of(k));
    fs::create_directory(place_of(k));
    return place_of(k);
  }
  /// What makes it the working folder of a program.
  static std::function<void()> in_place(const fs::path& place) {
    return [place = place.string()] {
      if (chdir(place.c_str()) != 0) _exit(126);
    };
  }
  /// The names of what is neither model nor target there.
  std::vector<std::string> parts(int k) const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(place_of(k)))
      if (const std::string name = entry.path().filename().string(); name != "out.h5" && name != "out.csv")
        names.push_back(name);
    std::sort(names.begin(), names.end());
    return names;
  }

  void stops_cleanly_on(int signal) {
    const pid_t child = start({"run", "pendulum.yaml", "--until", "1e8", "--set", "interval=1", "--output",
                               "out.h5", "--csv", "out.csv", "--json"});
    ASSERT_TRUE(has_rows(folder / "out.h5", 2));
    kill(child, signal);
    const Outcome outcome = wait_for(child);
    EXPECT_EQ(outcome.code, 3);
    EXPECT_THAT(outcome.err, HasSubstr("interrupted at t = "));
    const auto rows = read_results((folder / "out.h5").string()).time.size();
    EXPECT_THAT(outcome.err, HasSubstr("are kept: " + std::to_string(rows) + " rows in 'out.h5', " +
                                       std::to_string(rows) + " rows in 'out.csv' ("));
    const auto json = outcome.json();
    EXPECT_EQ(json.at("status"), "interrupted");
    const Results results = read_results((folder / "out.h5").string());
    ASSERT_GT(results.time.size(), 1);
    EXPECT_LE(results.time[results.time.size() - 1], json.at("time").number());
    EXPECT_EQ(test::Json::parse(results.summary_json).at("status"), "interrupted");
    EXPECT_EQ(csv_rows(folder / "out.csv").size(), static_cast<std::size_t>(results.time.size()));
  }
};

TEST_F(Interruption, AnInterruptKeepsWhatIsThere) { stops_cleanly_on(SIGINT); }

TEST_F(Interruption, ATerminationKeepsWhatIsThere) { stops_cleanly_on(SIGTERM); }

TEST_F(Interruption, AHangUpKeepsWhatIsThere) { stops_cleanly_on(SIGHUP); }

/// While modes are computed nothing has been made that could be kept: the signal itself is the end.
TEST_F(Interruption, ReadingAModelCanBeInterrupted) {
  write_file(
      folder / "slow.yaml",
      "mimbre: 1\nmaterials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}\n"
      "sections: {round: {type: round, diameter: 0.02}}\n"
      "bodies:\n  beam:\n    frame: {at: [0, 0, 0]}\n    flexible: {material: steel, section: round, "
      "nodes: {a: [0, 0, 0], b: [5, 0, 0]}, bars: {bar: {from: a, to: b, elements: 400}}, clamped: [a], "
      "dynamic_modes: 500}\n");
  for (const char* command : {"check", "run"}) {
    const pid_t child = start({command, "slow.yaml"});
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    kill(child, SIGINT);
    const Outcome outcome = wait_for(child);
    EXPECT_EQ(outcome.signal, SIGINT) << outcome.err;
    EXPECT_EQ(outcome.out, "");
  }
}

TEST_F(Interruption, AnInterruptedRunLeavesOlderFilesAlone) {
  ASSERT_EQ(run({"run", "pendulum.yaml", "--output", "out.h5", "--csv", "out.csv"}).code, 0);
  const std::string h5 = read_file(folder / "out.h5"), csv = read_file(folder / "out.csv");
  const pid_t child =
      start({"run", "pendulum.yaml", "--until", "1e8", "--output", "out.h5", "--csv", "out.csv"});
  ASSERT_TRUE(test::comes_true([&] { return !files("out.part-", ".h5").empty(); }));
  ASSERT_TRUE(has_rows(files("out.part-", ".h5")[0], 2));
  kill(child, SIGTERM);
  const Outcome outcome = wait_for(child);
  EXPECT_EQ(outcome.code, 3);
  EXPECT_TRUE(read_file(folder / "out.h5") == h5);
  EXPECT_TRUE(read_file(folder / "out.csv") == csv);
  const auto kept = files("out.part-", ".h5");
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_THAT(outcome.err, HasSubstr(kept[0].filename().string()));
  EXPECT_GT(read_results(kept[0].string()).time.size(), 1);
}

/// What killed runs leave goes when the same run comes to its end. What is of other options stays, and so
/// does that of which the user was told.
TEST_F(Interruption, WhatKilledRunsLeftGoesWithTheWholeRun) {
  write_file(folder / "out.h5", "older");
  write_file(folder / "out.csv", "older");
  const std::vector<std::string> same{"run", "pendulum.yaml", "--step", "0.0001", "--until",
                                      "60",  "--output",      "out.h5", "--csv",  "out.csv"};
  std::vector<std::string> other = same;
  other.insert(other.end(), {"--set", "length=2"});
  const auto end_by = [&](int signal, const std::vector<std::string>& arguments) {
    const auto before = files("out.part-", ".h5").size();
    const pid_t child = start(arguments);
    const auto mine = [&] { return files("out.part-" + std::to_string(child), ".h5"); };
    EXPECT_TRUE(test::comes_true([&] { return !mine().empty(); }));
    EXPECT_TRUE(has_rows(mine()[0], 2));
    kill(child, signal);
    wait_for(child);
    EXPECT_EQ(files("out.part-", ".h5").size(), before + 1);
    return child;
  };
  for (int k = 0; k < 3; ++k) end_by(SIGKILL, same);
  const pid_t of_other = end_by(SIGKILL, other), told = end_by(SIGINT, same);
  ASSERT_EQ(files("out.part-", ".h5").size(), 5u);
  const Outcome outcome = run(same);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const auto left = [&](pid_t of, const char* ending) {
    return files("out.part-" + std::to_string(of), ending).size();
  };
  EXPECT_EQ(files("out.part-", ".h5").size(), 2u);
  EXPECT_EQ(left(of_other, ".h5"), 1u);
  EXPECT_EQ(left(told, ".h5"), 1u);
  EXPECT_EQ(left(of_other, ".csv"), 1u);
}

/// How many kills are wanted (scripts/kill-runs).
int kills_wanted(int otherwise) {
  const char* const given = std::getenv("MIMBRE_KILLS");
  return given ? std::atoi(given) : otherwise;
}

/// Says how far a long test is.
void say_progress(int done, int all, int every, const std::string& what) {
  if (done % every == 0) std::cout << done << " of " << all << ' ' << what << std::endl;
}

/// Of runs with rows far apart as with rows close together, four at once. A second of its own time: one that
/// waits for the processor has nothing to lose meanwhile.
TEST_F(Interruption, OfAKilledRunNoMoreThanASecondIsLost) {
  using Clock = std::chrono::steady_clock;
  struct Victim {
    fs::path place;
    int signal;
    std::chrono::milliseconds pause;
    pid_t child;
    Clock::time_point end = Clock::time_point::max();  ///< known when its file is there
    bool killed = false;
    fs::file_time_type written{};  ///< its file, when it was last looked at
    double worked = 0;             ///< s, when that had changed
    double lost = 0;               ///< s
  };
  const int kills = kills_wanted(4);
  const int signals[] = {SIGKILL, SIGKILL, SIGTERM, SIGHUP};
  std::uint64_t state = 12345;
  double most_lost = 0;
  for (int k = 0; k < kills; k += 4) {
    std::vector<Victim> victims;
    for (int i = 0; i < 4; ++i) {
      state = state * 6364136223846793005u + 1442695040888963407u;
      const fs::path place = own_place(i);
      const auto pause = std::chrono::milliseconds(100 + static_cast<int>((state >> 33) % 1100));
      const pid_t child =
          start({"run", "../pendulum.yaml", "--until", "1e8", "--set",
                 (i + k / 4) % 2 ? "interval=0.01" : "interval=200", "--output", "out.h5", "--quiet"},
                in_place(place));
      victims.push_back({place, signals[i], pause, child});
    }
    const auto give_up = Clock::now() + std::chrono::minutes(5);
    for (int alive = 4; alive > 0 && Clock::now() < give_up;
         std::this_thread::sleep_for(std::chrono::milliseconds(1)))
      for (Victim& victim : victims) {
        if (victim.killed || !fs::exists(victim.place / "out.h5")) continue;
        const auto now = Clock::now();
        if (victim.end == Clock::time_point::max()) victim.end = now + victim.pause;
        // All that waits is written whenever the file is.
        const double worked = cpu_seconds(victim.child);
        if (const auto written = fs::last_write_time(victim.place / "out.h5"); written != victim.written) {
          victim.written = written;
          victim.worked = worked;
        }
        if (now < victim.end) continue;
        kill(victim.child, victim.signal);
        victim.killed = true;
        victim.lost = worked - victim.worked;
        --alive;
      }
    for (const Victim& victim : victims) {
      ASSERT_TRUE(victim.killed) << "no results appear";
      EXPECT_EQ(wait_for(victim.child).signal, victim.signal == SIGKILL ? SIGKILL : 0);
      const fs::path file = victim.place / "out.h5";
      const Results results = read_results(file.string());
      EXPECT_EQ(results.summary_json.empty(), victim.signal == SIGKILL);
      EXPECT_LT(victim.lost, 1);
      most_lost = std::max(most_lost, victim.lost);
      for (Eigen::Index i = 1; i < results.time.size(); ++i) ASSERT_GT(results.time[i], results.time[i - 1]);
    }
    say_progress(k + 4, kills, 100, "runs ended, which lost at most " + std::to_string(most_lost) + " s");
  }
}

/// While the program starts, reads its model, makes its files: what stands at the targets is whole, and the
/// next run, another one, does not mind what was left beside them, and touches nothing that was kept.
TEST_F(Interruption, KilledEarlyARunBreaksNothing) {
  ASSERT_EQ(run({"run", "pendulum.yaml", "-o", "older.h5", "--csv", "older.csv", "-q"}).code, 0);
  const std::string h5 = read_file(folder / "older.h5"), csv = read_file(folder / "older.csv");
  constexpr int count = 9;
  for (const auto& [signal, older] :
       {std::pair{SIGKILL, false}, {SIGKILL, true}, {SIGTERM, false}, {SIGHUP, true}}) {
    SCOPED_TRACE("signal " + std::to_string(signal) + (older ? " over older files" : ""));
    std::vector<pid_t> children;
    const auto begin = [&](int k, const char* until) {
      children.push_back(
          start({"run", "../pendulum.yaml", "--until", until, "-o", "out.h5", "--csv", "out.csv", "-q"},
                in_place(place_of(k))));
    };
    for (int k = 0; k < count; ++k) {
      own_place(k);
      if (older) write_file(place_of(k) / "out.h5", h5);
      if (older) write_file(place_of(k) / "out.csv", csv);
    }
    for (int k = 0; k < count; ++k) {
      begin(k, "1e8");
      // 0 to 120 ms after its start, the processor's time shared by all that run.
      std::this_thread::sleep_for(std::chrono::milliseconds(15 * k));
      kill(children.back(), signal);
    }
    std::vector<std::vector<std::string>> left;
    for (int k = 0; k < count; ++k) {
      const Outcome outcome = wait_for(children[static_cast<std::size_t>(k)]);
      EXPECT_TRUE(outcome.signal == signal || (signal != SIGKILL && outcome.code == 3)) << outcome.err;
      const fs::path target = place_of(k) / "out.h5";
      if (older) {
        EXPECT_TRUE(read_file(target) == h5);
        EXPECT_TRUE(read_file(place_of(k) / "out.csv") == csv);
      } else if (fs::exists(target)) {
        EXPECT_GE(read_results(target.string()).time.size(), 0);
      }
      left.push_back(parts(k));
      for (const std::string& part : left.back())
        if (part.ends_with(".h5") && outcome.code == 3) {
          EXPECT_GE(read_results((place_of(k) / part).string()).time.size(), 0);
        }
    }
    children.clear();
    for (int k = 0; k < count; ++k) begin(k, "1");
    for (int k = 0; k < count; ++k) {
      EXPECT_EQ(wait_for(children[static_cast<std::size_t>(k)]).code, 0);
      EXPECT_EQ(read_results((place_of(k) / "out.h5").string()).time.size(), 101);
      EXPECT_EQ(csv_rows(place_of(k) / "out.csv").size(), 101u);
      const std::vector<std::string> before = left[static_cast<std::size_t>(k)], now = parts(k);
      // The next run removes what a killed run had no time to keep.
      if (signal == SIGKILL) {
        EXPECT_TRUE(std::includes(before.begin(), before.end(), now.begin(), now.end()));
      } else {
        EXPECT_EQ(now, before);
      }
    }
  }
}

/// With MIMBRE_KILLS, a pair for ten kills.
TEST_F(Interruption, OfTwoRacingRunsOneWinsWhole) {
  const int pairs = std::max(kills_wanted(10) / 10, 1);
  int both_won = 0;  // one after the other
  const auto begin = [&] {
    return start({"run", "pendulum.yaml", "--until", "300", "-o", "out.h5", "--csv", "out.csv", "--quiet"});
  };
  for (int pair = 0; pair < pairs; ++pair) {
    fs::remove(folder / "out.h5");
    fs::remove(folder / "out.csv");
    const pid_t children[] = {begin(), begin()};
    int won = 0;
    for (const pid_t child : children) {
      const int code = wait_for(child).code;
      won += code == 0;
      EXPECT_TRUE(code == 0 || code == 3 || code == 1) << code;
    }
    EXPECT_GE(won, 1);
    both_won += won == 2;
    const Results results = read_results((folder / "out.h5").string());
    EXPECT_EQ(results.time.size(), 30001);
    EXPECT_EQ(test::Json::parse(results.summary_json).at("status"), "ok");
    EXPECT_EQ(csv_rows(folder / "out.csv").size(), 30001u);
    say_progress(pair + 1, pairs, 10, "pairs raced, of which both won in " + std::to_string(both_won));
  }
}

TEST_F(Interruption, AFailureLeavesOlderFilesWhole) {
  ASSERT_EQ(run({"run", "pendulum.yaml", "--output", "out.h5", "--csv", "out.csv"}).code, 0);
  const std::string h5 = read_file(folder / "out.h5"), csv = read_file(folder / "out.csv");
  const Outcome full =
      run({"run", "pendulum.yaml", "--until", "400", "-o", "out.h5", "--csv", "out.csv"}, [] {
        const rlimit limit{2'000'000, 2'000'000};
        setrlimit(RLIMIT_FSIZE, &limit);
      });
  EXPECT_EQ(full.code, 3);
  EXPECT_THAT(full.err, HasSubstr("File too large"));
  EXPECT_THAT(full.err, HasSubstr("rows are kept in 'out.part-"));
  EXPECT_TRUE(read_file(folder / "out.h5") == h5);
  EXPECT_TRUE(read_file(folder / "out.csv") == csv);
}

TEST_F(Interruption, AStandardErrorThatTakesNothingChangesNothingElse) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  const auto full = [] { dup2(open("/dev/full", O_WRONLY), STDERR_FILENO); };
  const auto closed = [] {
    close(STDIN_FILENO);
    close(STDERR_FILENO);
  };
  EXPECT_EQ(run({"check", "nope.yaml"}, full).code, 1);
  EXPECT_EQ(run({"check", "nope.yaml"}, closed).code, 1);
  EXPECT_EQ(run({"nonsense"}, closed).code, 2);
  for (const auto& prepare : {std::function<void()>(full), std::function<void()>(closed)}) {
    fs::remove(folder / "out.h5");
    // With a warning on the way.
    write_file(folder / "warned.yaml",
               pendulum + "roads:\n  lane: {over: distance, points: [[0, 0], [1, 0]]}\n");
    ASSERT_EQ(run({"run", "warned.yaml", "-o", "out.h5"}, prepare).code, 0);
    EXPECT_EQ(read_results((folder / "out.h5").string()).time.size(), 101);
  }
  // The numbers of closed descriptors are not given to files.
  const Outcome none =
      run({"run", "pendulum.yaml", "--csv", "out.csv", "--json"}, [] { close(STDOUT_FILENO); });
  EXPECT_EQ(none.code, 3);
  EXPECT_EQ(csv_rows(folder / "out.csv").size(), 101u);
  EXPECT_EQ(read_file(folder / "out.csv").find("status"), std::string::npos);
}

TEST_F(Interruption, NoOutputReplacesAnInput) {
  write_file(folder / "bob.yaml",
             "bodies:\n  bob: {mass: 2, com: [1, 0, 0], inertia: [0.1, 0.1, 0.1]}\njoints:\n"
             "  hinge: {type: revolute, between: [ground, bob], at: [0, 0, 0], axis: [0, 1, 0]}\n");
  write_file(folder / "two.csv.part",
             "mimbre: 1\nsubsystems:\n  arm: {file: bob.yaml}\ninstances:\n  left: {of: arm}\n"
             "simulation: {step: 0.01, end: 0.1}\n");
  const std::string part = read_file(folder / "bob.yaml"), model = read_file(folder / "two.csv.part");
  EXPECT_EQ(run({"run", "two.csv.part", "--csv", "two.csv"}).code, 0);
  EXPECT_EQ(read_file(folder / "two.csv.part"), model);
  for (const char* option : {"--csv", "-o"}) {
    const Outcome outcome = run({"run", "two.csv.part", option, "bob.yaml"});
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("'bob.yaml' would be overwritten"));
    EXPECT_EQ(read_file(folder / "bob.yaml"), part);
  }
}

/// Nor another output, however its place is written, though nothing stands there yet.
TEST_F(Interruption, NoOutputReplacesAnother) {
  fs::create_directory(folder / "sub");
  for (const char* other : {"new.h5", "./new.h5", "sub/../new.h5"}) {
    const Outcome outcome = run({"run", "pendulum.yaml", "-o", "new.h5", "--csv", other});
    EXPECT_EQ(outcome.code, 2) << other;
    EXPECT_THAT(outcome.err, HasSubstr("would be overwritten")) << other;
    EXPECT_FALSE(fs::exists(folder / "new.h5"));
  }
}

TEST_F(Interruption, PipesAndDevicesAreNotRead) {
  ASSERT_EQ(mkfifo((folder / "pipe.h5").c_str(), 0600), 0);
  const Outcome report = run({"report", "pipe.h5"});
  EXPECT_EQ(report.code, 1);
  EXPECT_THAT(report.err, HasSubstr("pipe.h5: error: not a file"));
  const std::string element = MIMBRE_SOURCE_DIR "/tests/data/calculix/elements/C3D4.inp";
  const Outcome endless = run({"reduce", element, "--interface", "a=nodes:/dev/zero", "-o", "a.h5"});
  EXPECT_NE(endless.code, 0);
  EXPECT_THAT(endless.err, HasSubstr("/dev/zero"));
  EXPECT_THAT(endless.err, HasSubstr("a plain file is needed"));
  write_file(folder / "deep.yaml", std::string(4'000'000, '['));
  const Outcome deep = run({"check", "deep.yaml"}, [] {
    const rlimit limit{600'000'000, 600'000'000};
    setrlimit(RLIMIT_AS, &limit);
  });
  EXPECT_EQ(deep.code, 1);
  EXPECT_THAT(deep.err, HasSubstr("deep.yaml:1:1: error: more than 500000 brackets"));
}

TEST_F(Interruption, AKilledRunLeavesAReadableFile) {
  const pid_t child = start(
      {"run", "pendulum.yaml", "--until", "1e8", "--set", "interval=1", "--output", "out.h5", "--quiet"});
  ASSERT_TRUE(has_rows(folder / "out.h5", 5));
  kill(child, SIGKILL);
  EXPECT_EQ(wait_for(child).signal, SIGKILL);
  const Results results = read_results((folder / "out.h5").string());
  EXPECT_GT(results.time.size(), 1);
  EXPECT_EQ(results.summary_json, "");

  // What it is compared with has another end, and who reads the differences is told.
  ASSERT_EQ(run({"run", "pendulum.yaml", "--output", "whole.h5", "--until", "2", "--quiet"}).code, 0);
  const Outcome compared = run({"compare", "whole.h5", "out.h5"});
  EXPECT_EQ(compared.code, 0);
  EXPECT_THAT(compared.err, HasSubstr("warning: the run of 'out.h5' was cut short: its results end at t = "));
  EXPECT_THAT(compared.err,
              HasSubstr("warning: only t = 0 to 2 s is compared, which both have; 'out.h5' goes from 0"));
  const auto json = run({"compare", "whole.h5", "out.h5", "--json"}).json();
  EXPECT_EQ(json.at("from"), 0);
  EXPECT_NEAR(json.at("until").number(), 2, 1e-9);
  EXPECT_EQ(json.at("warnings").size(), 2u);
  EXPECT_EQ(run({"compare", "whole.h5", "whole.h5"}).err, "");
}

TEST_F(Interruption, AFullDiskIsAnErrorThatNamesTheFile) {
  const auto disk_of = [](rlim_t bytes) {
    return [bytes] {
      const rlimit limit{bytes, bytes};
      setrlimit(RLIMIT_FSIZE, &limit);
    };
  };
  const Outcome results_full =
      run({"run", "pendulum.yaml", "--until", "400", "--output", "out.h5", "--json"}, disk_of(3'000'000));
  EXPECT_EQ(results_full.code, 3) << results_full.err;
  EXPECT_THAT(results_full.err, HasSubstr("cannot write results file 'out.h5'"));
  EXPECT_EQ(results_full.json().at("status"), "failed");
  EXPECT_LT(results_full.json().at("steps"), 40000);
  const Results results = read_results((folder / "out.h5").string());
  EXPECT_GT(results.time.size(), 1);
  EXPECT_EQ(results.summary_json, "");

  const Outcome csv_full =
      run({"run", "pendulum.yaml", "--until", "200", "--csv", "out.csv", "--json"}, disk_of(200'000));
  EXPECT_EQ(csv_full.code, 3) << csv_full.err;
  EXPECT_THAT(csv_full.err, HasSubstr("cannot write CSV file 'out.csv'"));
  EXPECT_EQ(csv_full.json().at("status"), "failed");

  // No room even for the beginning.
  EXPECT_EQ(run({"run", "pendulum.yaml", "--output", "none.h5"}, disk_of(10'000)).code, 3);
  EXPECT_FALSE(fs::exists(folder / "none.h5"));
}

TEST_F(Interruption, AFullStandardOutputIsAnError) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  const Outcome outcome =
      run({"check", "pendulum.yaml"}, [] { dup2(open("/dev/full", O_WRONLY), STDOUT_FILENO); });
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("standard output"));
}

}  // namespace
}  // namespace mimbre::app_test::interruption_test
