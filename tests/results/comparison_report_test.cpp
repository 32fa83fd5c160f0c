#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mimbre/diagnostics.h"
#include "mimbre/report.h"
#include "support/report_data.h"

namespace mimbre::comparison_report_test {
namespace {

using report_data::data_text;
using report_data::decoded;
using report_data::Json;
using report_data::small_results;
using testing::ElementsAre;
using testing::HasSubstr;

/// Channel "x" (m) at the given times, and one more.
Results run_of(const std::vector<double>& time, const std::vector<double>& x, const ChannelInfo& other) {
  Results results;
  const auto instants = static_cast<Eigen::Index>(time.size());
  results.header.title = "A run";
  results.header.step = 0.01;
  results.header.channels = {{"x", "m", "place"}, other};
  results.time = Eigen::VectorXd::Map(time.data(), instants);
  results.channels.setZero(instants, 2);
  results.channels.col(0) = Eigen::VectorXd::Map(x.data(), instants);
  results.modes.resize(instants, 0);
  results.poses.assign(time.size(), Eigen::Matrix<double, 7, Eigen::Dynamic>(7, 0));
  return results;
}

Json data_of(const std::vector<ComparedRun>& runs, const ReportOptions& options = {}) {
  return Json::parse(data_text(comparison_html(runs, options)));
}

/// What the run's array `name` holds of a channel that is listed under `list`.
std::vector<double> curve(const Json& data, const char* list, std::size_t channel, std::size_t run,
                          const char* name) {
  const auto values = decoded<float>(data.at("runs").at(run).at(name));
  const char* const times = std::string(list) == "curves" ? "time" : "commonTime";
  const std::size_t length = data.at("runs").at(run).at(times).at("size");
  std::size_t at = 0;
  for (std::size_t k = 0; k <= channel; ++k)
    for (const Json& entry : data.at("channels").at(k).at(list)) {
      if (entry.at("run") != run) continue;
      if (k < channel) {
        at += length;
        continue;
      }
      std::vector<double> result;
      for (std::size_t i = 0; i < length; ++i)
        result.push_back(static_cast<double>(values[at + i]) + entry.at("offset").number());
      return result;
    }
  ADD_FAILURE() << "no curve of run " << run;
  return {};
}

class ComparisonReport : public testing::Test {
 protected:
  void SetUp() override {
    if (!report_available()) GTEST_SKIP() << "built without the report page";
  }
};

TEST_F(ComparisonReport, DifferentGridsAndEndsAreInterpolated) {
  // x = t on the first, sampled every second; x = t + 0.5 t on the second, every half second up to 1.5 s.
  const ComparedRun first{run_of({0, 1, 2, 3}, {0, 1, 2, 3}, {"a", "m", ""}), "first.h5", "one"};
  const ComparedRun second{run_of({0, 0.5, 1, 1.5}, {0, 0.75, 1.5, 2.25}, {"b", "m", ""}), "second.h5",
                           "two"};
  const Json data = data_of({first, second});
  EXPECT_EQ(data.at("format"), "mimbre-comparison-1");
  ASSERT_EQ(data.at("channels").size(), 1U);  // a and b are in one run only
  EXPECT_EQ(data.at("channels").at(0).at("name"), "x");
  EXPECT_THAT(decoded<double>(data.at("runs").at(1).at("time")), ElementsAre(0, 0.5, 1, 1.5));
  EXPECT_THAT(curve(data, "curves", 0, 0, "values"), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(curve(data, "curves", 0, 1, "values"), ElementsAre(0, 0.75, 1.5, 2.25));
  // The coarser grid within what both have: 0 and 1 s.
  EXPECT_THAT(decoded<double>(data.at("runs").at(1).at("commonTime")), ElementsAre(0, 1));
  EXPECT_THAT(curve(data, "deviations", 0, 1, "differences"), ElementsAre(0, 0.5));
  const Json& deviation = data.at("channels").at(0).at("deviations").at(0);
  EXPECT_EQ(deviation.at("run"), 1);
  EXPECT_EQ(deviation.at("largest"), 0.5);
  EXPECT_EQ(deviation.at("mean"), 0.25);
  EXPECT_EQ(deviation.at("at"), 1);
  EXPECT_EQ(deviation.at("amplitude"), 3);
  EXPECT_EQ(data.at("runs").at(0).at("label"), "one");
  EXPECT_EQ(data.at("runs").at(1).at("file"), "second.h5");
}

TEST_F(ComparisonReport, DeviationsAreThoseOfCompare) {
  Results a = small_results(201), b = small_results(301);
  b.time *= 0.4;  // another grid, another end
  b.channels.col(1).array() += 0.3 * b.time.array().sin();
  const Json data = data_of({{a, "a.h5", ""}, {b, "b.h5", ""}});
  const auto expected = compare(a, b);
  ASSERT_EQ(data.at("channels").size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    const Json& deviation = data.at("channels").at(k).at("deviations").at(0);
    EXPECT_EQ(data.at("channels").at(k).at("name"), expected[k].name);
    EXPECT_EQ(deviation.at("mean"), expected[k].mean_difference);
    EXPECT_EQ(deviation.at("largest"), expected[k].max_difference);
    EXPECT_EQ(deviation.at("at"), expected[k].at_time);
    // The curve that is drawn has the same peak.
    double largest = 0;
    for (const double value : curve(data, "deviations", k, 1, "differences"))
      largest = std::max(largest, std::abs(value));
    EXPECT_NEAR(largest, expected[k].max_difference, 1e-6 * expected[k].max_difference);
  }
}

TEST_F(ComparisonReport, ThinnedDifferencesKeepTheirPeaks) {
  const Results a = small_results(10001);
  Results b = a;
  b.channels(4321, 1) += 7;
  ReportOptions options;
  options.max_samples = 100;
  const Json data = data_of({{a, "a.h5", ""}, {b, "b.h5", ""}}, options);
  EXPECT_LE(data.at("runs").at(1).at("commonTime").at("size"), 102);
  const auto differences = curve(data, "deviations", 1, 1, "differences");
  EXPECT_FLOAT_EQ(static_cast<float>(*std::max_element(differences.begin(), differences.end())), 7);
}

TEST_F(ComparisonReport, ChannelsThatTheFirstRunHasNotAreDrawnWithoutDifferences) {
  const ChannelInfo y{"y", "rad", ""};
  const Json data = data_of({{run_of({0, 1}, {0, 1}, {"y", "deg", ""}), "a.h5", ""},
                             {run_of({0, 1}, {0, 2}, y), "b.h5", ""},
                             {run_of({0, 1}, {0, 3}, y), "c.h5", ""}});
  ASSERT_EQ(data.at("channels").size(), 2U);  // y in degrees is another channel
  EXPECT_EQ(data.at("channels").at(1).at("unit"), "rad");
  EXPECT_EQ(data.at("channels").at(1).at("curves").size(), 2U);
  EXPECT_TRUE(data.at("channels").at(1).at("deviations").empty());
  EXPECT_THAT(curve(data, "deviations", 0, 2, "differences"), ElementsAre(0, 2));
}

TEST_F(ComparisonReport, AFailedRunKeepsItsSoundValues) {
  const Results first = run_of({0, 1, 2, 3}, {0, 1e-3, 2e-3, 3e-3}, {"a", "m", ""});
  Results failed = run_of({0, 1, 2}, {0, 1e-3, 1e9}, {"a", "m", ""});
  failed.summary_json = R"({"status": "failed", "message": "no convergence"})";
  const Json data = data_of({{first, "first.h5", ""}, {failed, "failed.h5", ""}});
  EXPECT_NEAR(curve(data, "curves", 0, 1, "values")[1], 1e-3, 1e-9);
  EXPECT_NEAR(curve(data, "deviations", 0, 1, "differences")[1], 0, 1e-9);
  EXPECT_EQ(data.at("runs").at(1).at("summary").at("message"), "no convergence");
  EXPECT_TRUE(data.at("runs").at(0).at("summary").is_null());
}

TEST_F(ComparisonReport, RunsWithoutInstantsOrCommonTimeAreShownWithoutDifferences) {
  const ChannelInfo other{"a", "m", ""};
  const Json data = data_of({{run_of({0, 1}, {0, 1}, other), "a.h5", ""},
                             {run_of({}, {}, other), "b.h5", ""},
                             {run_of({5, 6}, {5, 6}, other), "c.h5", ""}});
  EXPECT_EQ(data.at("runs").at(1).at("time").at("size"), 0);
  EXPECT_TRUE(data.at("channels").at(0).at("deviations").empty());
  EXPECT_THAT(curve(data, "curves", 0, 2, "values"), ElementsAre(5, 6));
  Results broken = run_of({1, 0}, {0, 1}, other);
  EXPECT_THROW(data_of({{run_of({0, 1}, {0, 1}, other), "a.h5", ""}, {broken, "b.h5", ""}}), InputError);
}

TEST_F(ComparisonReport, NumbersThatAreNoneAreNull) {
  const Results first = run_of({0, 1}, {0, 1}, {"a", "m", ""});
  Results broken = first;
  broken.channels(1, 0) = std::numeric_limits<double>::quiet_NaN();
  const Json data = data_of({{first, "a.h5", ""}, {broken, "b.h5", ""}});
  EXPECT_TRUE(data.at("channels").at(0).at("deviations").at(0).at("largest").is_null());
  EXPECT_TRUE(std::isnan(curve(data, "curves", 0, 1, "values")[1]));
}

TEST_F(ComparisonReport, TheAnimationIsTheFirstRunsWithTheOthersBehind) {
  Results other = small_results(5);
  other.header.bodies[0].name = "stone";
  const Json data = data_of({{small_results(), "a.h5", ""}, {other, "b.h5", ""}});
  EXPECT_EQ(data.at("bodies").at(0).at("name"), "ball");
  EXPECT_EQ(data.at("animation").at("time").at("size"), 3);
  EXPECT_EQ(data.at("roads").at(0).at("name"), "track");
  const Json& ghost = data.at("ghosts").at(0);
  EXPECT_EQ(ghost.at("bodies").at(0).at("name"), "stone");
  EXPECT_EQ(ghost.at("animation").at("time").at("size"), 5);
  const Json alike = data_of({{small_results(), "a.h5", ""}, {small_results(5), "b.h5", ""}});
  EXPECT_FALSE(alike.at("ghosts").at(0).contains("bodies"));
}

TEST_F(ComparisonReport, ARunComparedWithItselfDiffersByNothing) {
  const Results results = small_results(50);
  const Json data = data_of({{results, "a.h5", ""}, {results, "a.h5", ""}});
  for (const Json& channel : data.at("channels")) EXPECT_EQ(channel.at("deviations").at(0).at("largest"), 0);
  EXPECT_NE(data.at("runs").at(0).at("label"), data.at("runs").at(1).at("label"));
}

TEST_F(ComparisonReport, ShownChannelsAreAmongTheShared) {
  ReportOptions options;
  options.channels = {"arm.tip"};
  const ComparedRun run{small_results(), "a.h5", ""};
  EXPECT_EQ(data_of({run, run}, options).at("shown"), (std::vector<double>{1}));
  options.channels = {"arm.tup"};
  EXPECT_THROW(data_of({run, run}, options), InputError);
}

TEST_F(ComparisonReport, WhatCannotBeComparedIsRefused) {
  const auto message = [](const std::vector<ComparedRun>& runs) -> std::string {
    try {
      comparison_html(runs);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  const ComparedRun run{small_results(), "a.h5", ""};
  EXPECT_THAT(message({run}), HasSubstr("at least two runs"));
  Results stranger = small_results();
  stranger.header.channels[0].name = "other";
  stranger.header.channels[1].unit = "deg";
  EXPECT_THAT(message({run, {stranger, "b.h5", ""}}),
              HasSubstr("no two of the runs have a channel in common"));
  Results damaged = small_results();
  damaged.modes.resize(3, 2);
  EXPECT_THAT(message({run, {damaged, "b.h5", ""}}), HasSubstr("modes"));
}

TEST_F(ComparisonReport, HostileLabelsStayText) {
  const std::string hostile = "</script><script>alert(1)</script>";
  const ComparedRun run{small_results(), hostile, hostile};
  const std::string html = comparison_html({run, run});
  EXPECT_EQ(data_text(html).find('<'), std::string::npos);
  EXPECT_THAT(html, testing::Not(HasSubstr("alert(1)</script>")));
}

}  // namespace
}  // namespace mimbre::comparison_report_test
