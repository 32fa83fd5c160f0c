#include <gmock/gmock.h>

#include "app/program.h"
#include "mimbre/results.h"

namespace mimbre::app_test {
namespace {

using ::testing::HasSubstr;

/// Runs that do not come to their end.
class Interruption : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_file(folder / "pendulum.yaml", pendulum);
  }

  bool appears(const char* name) const {
    for (int k = 0; k < 2000; ++k) {
      if (fs::exists(folder / name)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }

  void stops_cleanly_on(int signal) {
    const pid_t child = start({"run", "pendulum.yaml", "--until", "1e8", "--set", "interval=1", "--output",
                               "out.h5", "--csv", "out.csv", "--json"});
    ASSERT_TRUE(appears("out.csv.part"));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    kill(child, signal);
    const Outcome outcome = wait_for(child);
    EXPECT_EQ(outcome.code, 3);
    EXPECT_THAT(outcome.err, HasSubstr("interrupted at t = "));
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

TEST_F(Interruption, AKilledRunLeavesAReadableFile) {
  const pid_t child = start(
      {"run", "pendulum.yaml", "--until", "1e8", "--set", "interval=1", "--output", "out.h5", "--quiet"});
  ASSERT_TRUE(appears("out.h5"));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  kill(child, SIGKILL);
  EXPECT_EQ(wait_for(child).signal, SIGKILL);
  const Results results = read_results((folder / "out.h5").string());
  EXPECT_GT(results.time.size(), 1);
  EXPECT_EQ(results.summary_json, "");
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
  EXPECT_EQ(run({"run", "pendulum.yaml", "--output", "none.h5"}, disk_of(10'000)).code, 1);
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
}  // namespace mimbre::app_test
