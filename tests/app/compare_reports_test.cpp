#include <gmock/gmock.h>

#include "app/program.h"
#include "mimbre/report.h"
#include "mimbre/results.h"
#include "support/report_data.h"

namespace mimbre::app_test::compare_reports_test {
namespace {

using report_data::data_text;
using ::testing::HasSubstr;

/// Two runs of a pendulum, the second longer and with half the step.
class CompareReports : public ProgramTest {
 protected:
  void SetUp() override {
    if (!report_available()) GTEST_SKIP() << "built without the report page";
    ProgramTest::SetUp();
    write_file(folder / "pendulum.yaml", pendulum);
    const Outcome a = run({"run", "pendulum.yaml", "-o", "a.h5", "-q", "--json"});
    const Outcome b = run({"run", "pendulum.yaml", "-o", "b.h5", "-q", "--json", "--step", "0.005", "--set",
                           "interval=0.02", "--until", "2"});
    ASSERT_EQ(a.code, 0) << a.err;
    ASSERT_EQ(b.code, 0) << b.err;
    write_file(folder / "a.json", a.out);
    write_file(folder / "b.json", b.out);
  }

  test::Json page(const std::string& name) const {
    return test::Json::parse(data_text(read_file(folder / name)));
  }
};

TEST_F(CompareReports, TwoRunsOnOnePage) {
  const Outcome outcome = run({"report", "a.h5", "b.h5", "-o", "page.html"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "page.html\n");
  const auto data = page("page.html");
  ASSERT_EQ(data.at("runs").size(), 2u);
  EXPECT_EQ(data.at("runs")[0].at("label"), "10 ms");
  EXPECT_EQ(data.at("runs")[1].at("label"), "interval=0.02, 5 ms");
  EXPECT_EQ(data.at("runs")[0].at("instants"), 101);
  EXPECT_EQ(data.at("runs")[1].at("instants"), 101);
  EXPECT_EQ(data.at("runs")[1].at("commonTime").at("size"), 51);
  const auto differences = run({"compare", "a.h5", "b.h5", "--json"}).json().at("channels");
  EXPECT_EQ(data.at("channels").size(), differences.size());
  for (const auto& channel : data.at("channels")) {
    const auto& deviation = channel.at("deviations")[0];
    const auto& expected = differences.at(channel.at("name").text());
    EXPECT_EQ(deviation.at("largest"), expected.at("max_difference"));
    EXPECT_EQ(deviation.at("mean"), expected.at("mean_difference"));
  }
}

TEST_F(CompareReports, LabelsOncePerFile) {
  ASSERT_EQ(run({"report", "--label", "coarse", "a.h5", "--label", "fine", "b.h5", "-o", "page.html"}).code,
            0);
  EXPECT_EQ(page("page.html").at("runs")[0].at("label"), "coarse");
  EXPECT_EQ(page("page.html").at("runs")[1].at("label"), "fine");
  const Outcome one = run({"report", "a.h5", "b.h5", "--label", "coarse", "-o", "other.html"});
  EXPECT_EQ(one.code, 2);
  EXPECT_THAT(one.err, HasSubstr("--label is given 1 times for 2 results files"));
  EXPECT_FALSE(fs::exists(folder / "other.html"));
  EXPECT_EQ(run({"report", "a.h5", "--label", "coarse"}).code, 2);
}

TEST_F(CompareReports, TimesComeFromTheSummariesOfTheRuns) {
  ASSERT_EQ(run({"report", "a.h5", "b.h5", "-o", "plain.html"}).code, 0);
  EXPECT_FALSE(page("plain.html").at("runs")[0].at("summary").contains("cpu_seconds"));
  const Outcome outcome =
      run({"report", "a.h5", "b.h5", "--summary", "a.json", "--summary", "b.json", "-o", "page.html"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_GT(page("page.html").at("runs")[1].at("summary").at("cpu_seconds"), 0);
  EXPECT_GT(page("page.html").at("runs")[1].at("summary").at("real_time_factor"), 0);

  const Outcome swapped =
      run({"report", "a.h5", "b.h5", "--summary", "b.json", "--summary", "a.json", "-o", "page.html"});
  EXPECT_EQ(swapped.code, 1);
  EXPECT_THAT(swapped.err, HasSubstr("b.json: error: is of another run than the results: 'steps' differs"));
  EXPECT_EQ(run({"report", "a.h5", "--summary", "a.json", "-o", "page.html"}).code, 0);
  EXPECT_EQ(run({"report", "a.h5", "--summary", "missing.json", "-o", "page.html"}).code, 1);
  EXPECT_EQ(run({"report", "a.h5", "--summary", "pendulum.yaml", "-o", "page.html"}).code, 1);
}

TEST_F(CompareReports, AFileGivenTwiceDiffersByNothing) {
  const Outcome outcome = run({"report", "a.h5", "a.h5", "b.h5", "-o", "page.html"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto data = page("page.html");
  EXPECT_NE(data.at("runs")[0].at("label"), data.at("runs")[1].at("label"));
  for (const auto& channel : data.at("channels")) EXPECT_EQ(channel.at("deviations")[0].at("largest"), 0);
}

/// A file with one channel; without a summary the run counts as cut short.
void write_results(const fs::path& path, const std::string& channel, int rows, const std::string& summary) {
  ResultsHeader header;
  header.step = 0.01;
  header.channels = {{channel, "m", ""}};
  ResultsWriter writer(path.string(), header);
  for (int k = 0; k < rows; ++k) {
    ResultsRow row;
    row.time = 0.01 * k;
    row.channels = Eigen::VectorXd::Constant(1, k);
    row.poses.resize(7, 0);
    writer.add(row);
  }
  writer.finish(summary);
}

TEST_F(CompareReports, ARunThatFailedIsComparedAsFarAsItGoes) {
  write_results(folder / "whole.h5", "x", 10, R"({"status": "ok"})");
  write_results(folder / "failed.h5", "x", 4, R"({"status": "failed", "message": "did not converge"})");
  const Outcome outcome = run({"report", "whole.h5", "failed.h5", "-o", "page.html"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto data = page("page.html");
  EXPECT_EQ(data.at("runs")[1].at("commonTime").at("size"), 4);
  EXPECT_EQ(data.at("runs")[1].at("summary").at("message"), "did not converge");
  EXPECT_EQ(data.at("channels")[0].at("deviations")[0].at("largest"), 0);
}

TEST_F(CompareReports, RunsWithoutACommonChannelAreRefused) {
  write_results(folder / "x.h5", "x", 3, "");
  write_results(folder / "y.h5", "y", 3, "");
  const Outcome outcome = run({"report", "x.h5", "y.h5", "-o", "page.html"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("no two of the runs have a channel in common"));
  EXPECT_FALSE(fs::exists(folder / "page.html"));
}

TEST_F(CompareReports, APageOfSeveralNeedsAName) {
  const Outcome outcome = run({"report", "a.h5", "b.h5"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("-o FILE.html"));
  EXPECT_EQ(run({"report", "a.h5", "b.h5", "-o", "b.h5"}).code, 2);
  EXPECT_EQ(run({"report", "a.h5", "missing.h5", "-o", "page.html"}).code, 1);
  EXPECT_FALSE(fs::exists(folder / "page.html"));
}

}  // namespace
}  // namespace mimbre::app_test::compare_reports_test
