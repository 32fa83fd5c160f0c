#include "mimbre/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include "mimbre/diagnostics.h"
#include "support/report_data.h"
#include "support/text.h"

namespace mimbre::report_test {
namespace {

using report_data::data_text;
using report_data::decoded;
using report_data::Json;
using report_data::small_results;
using testing::ElementsAre;
using testing::HasSubstr;

Json data_of(const Results& results, const ReportOptions& options = {}) {
  return Json::parse(data_text(report_html(results, options)));
}

class Report : public testing::Test {
 protected:
  void SetUp() override {
    if (!report_available()) GTEST_SKIP() << "built without the report page";
  }
};

TEST_F(Report, CarriesAnimationAndBodies) {
  const Results results = small_results();
  const Json data = data_of(results);
  const Json& animation = data.at("animation");
  EXPECT_THAT(decoded<double>(animation.at("time")), ElementsAre(0, 0.01, 0.02));
  EXPECT_THAT(decoded<double>(animation.at("positions")),
              ElementsAre(1e5, 2, 3, 4, 5, 6, 1e5 + 0.001, 2, 3, 4, 5, 6, 1e5 + 0.002, 2, 3, 4, 5, 6));
  const auto rotations = decoded<float>(animation.at("rotations"));
  ASSERT_EQ(rotations.size(), 3U * 2 * 4);
  EXPECT_EQ(rotations[0], 1);
  EXPECT_EQ(rotations[5], 1);
  EXPECT_THAT(decoded<float>(animation.at("modes")), ElementsAre(0, 0.5, 1));

  const Json& arm = data.at("bodies").at(1);
  EXPECT_EQ(arm.at("name"), "arm");
  EXPECT_EQ(arm.at("modes"), 1);
  EXPECT_THAT(decoded<float>(arm.at("points")), ElementsAre(0, 0, 0, 1.5, 0, 0));
  EXPECT_THAT(decoded<float>(arm.at("pointShapes")), ElementsAre(0, 0, 0, 0, 0, 1));
  EXPECT_THAT(decoded<std::uint32_t>(arm.at("lines")), ElementsAre(0, 1));
  const Json& ball = data.at("bodies").at(0).at("shapes").at(0);
  EXPECT_EQ(ball.at("kind"), "sphere");
  EXPECT_EQ(ball.at("size").at(0), 0.05);
  EXPECT_EQ(ball.at("rotation"), (std::vector<double>{1, 0, 0, 0, 1, 0, 0, 0, 1}));
  EXPECT_THAT(decoded<double>(data.at("roads").at(0).at("profile")), ElementsAre(0, 0.5, 10, 0.25));
}

TEST_F(Report, ChannelsKeepSevenDigitsOfTheirRange) {
  const Results results = small_results(500);
  const Json data = data_of(results);
  const auto values = decoded<float>(data.at("values"));
  ASSERT_EQ(values.size(), 1000U);
  for (int channel = 0; channel < 2; ++channel) {
    const double range = results.channels.col(channel).maxCoeff() - results.channels.col(channel).minCoeff();
    const double offset = data.at("channels").at(static_cast<std::size_t>(channel)).at("offset");
    for (int i = 0; i < 500; ++i)
      EXPECT_NEAR(static_cast<double>(values[static_cast<std::size_t>(500 * channel + i)]) + offset,
                  results.channels(i, channel), 1e-7 * range + 1e-9);
  }
  EXPECT_EQ(data.at("channels").at(0).at("name"), "ball.z");
  EXPECT_EQ(data.at("channels").at(1).at("unit"), "rad");
}

/// 0.3 turns an instant, written within ±π; what leaves ±π counts turns by itself and stays as it is.
TEST_F(Report, AnglesGoOnWhereTheyWouldJump) {
  Results results = small_results(50);
  results.header.channels[0].unit = "rad";
  for (int i = 0; i < 50; ++i) {
    const double angle = -0.6 * EIGEN_PI * i;
    results.channels(i, 0) = std::remainder(angle, 2 * EIGEN_PI);
    results.channels(i, 1) = 4 * i;
  }
  const Json data = data_of(results);
  const auto values = decoded<float>(data.at("values"));
  const double first = data.at("channels").at(0).at("offset"),
               second = data.at("channels").at(1).at("offset");
  for (int i = 0; i < 50; ++i) {
    EXPECT_NEAR(values[static_cast<std::size_t>(i)] + first, -0.6 * EIGEN_PI * i, 1e-4);
    EXPECT_NEAR(values[static_cast<std::size_t>(50 + i)] + second, 4 * i, 1e-4);
  }
}

TEST_F(Report, ElementsAndFramesAreCarriedAndChecked) {
  Results results = small_results();
  results.header.frames = {{"pin", spec::ground, {}, Eigen::MatrixXd(6, 0)},
                           {"eye", 1, {}, Eigen::MatrixXd::Ones(6, 1)}};
  results.header.elements = {{"hinge", "revolute", 0, 1, 0, {}}};
  const Json data = data_of(results);
  EXPECT_EQ(data.at("elements").at(0).at("kind"), "revolute");
  EXPECT_EQ(data.at("elements").at(0).at("b"), 1);
  EXPECT_EQ(data.at("frames").at(0).at("body"), -1);
  EXPECT_THAT(decoded<float>(data.at("frames").at(1).at("motion")), ElementsAre(1, 1, 1, 1, 1, 1));
  results.header.elements[0].frame_b = 2;
  EXPECT_THROW(report_html(results), InputError);
  results.header.elements.clear();
  results.header.frames[1].body = 2;
  EXPECT_THROW(report_html(results), InputError);
}

/// Four parts of stress at each end of each line, and the points of curves.
TEST_F(Report, StressOfBarsAndCurvesAreCarriedAndChecked) {
  Results results = small_results();
  BodyDrawing& arm = results.header.bodies[1];
  EXPECT_EQ(data_of(results).at("bodies").at(1).at("barStress").at("size"), 0);
  arm.bar_stress = Eigen::VectorXd::LinSpaced(8, 1, 8);
  arm.round_lines = {true};
  results.header.frames = {{"pin", spec::ground, {}, Eigen::MatrixXd(6, 0)}};
  results.header.elements = {{"wire", "on_curve", 0, 0, 0, Eigen::Matrix3Xd::Identity(3, 2)},
                             {"table", "on_plane", 0, 0, 0, {}}};
  const Json data = data_of(results), drawn = data.at("bodies").at(1);
  EXPECT_THAT(decoded<float>(drawn.at("barStress")), ElementsAre(1, 2, 3, 4, 5, 6, 7, 8));
  EXPECT_THAT(decoded<std::uint32_t>(drawn.at("roundLines")), ElementsAre(1));
  EXPECT_THAT(decoded<float>(data.at("elements").at(0).at("curve")), ElementsAre(1, 0, 0, 0, 1, 0));
  EXPECT_FALSE(data.at("elements").at(1).contains("curve"));
  arm.bar_stress = Eigen::MatrixXd::Ones(8, 2);
  EXPECT_THROW(report_html(results), InputError) << "stress of more modes than the body has";
  arm.bar_stress = Eigen::MatrixXd::Ones(4, 1);
  EXPECT_THROW(report_html(results), InputError);
}

TEST_F(Report, SummaryOptionsAndModelAreCarried) {
  Results results = small_results();
  const Json data = data_of(results);
  EXPECT_EQ(data.at("summary").at("warnings").at(0), "the step is large");
  EXPECT_EQ(data.at("options").at("length"), 1.5);
  EXPECT_EQ(data.at("model"), "mimbre: 1\n");
  EXPECT_EQ(data.at("instants"), 3);
  results.summary_json.clear();
  EXPECT_TRUE(data_of(results).at("summary").is_null());
}

TEST_F(Report, LongRecordsAreThinnedWithoutLosingPeaks) {
  Results results = small_results(10001);
  results.channels.col(1).setZero();
  results.channels(4321, 1) = 7;
  results.channels(8765, 1) = -3;
  ReportOptions options;
  options.max_frames = 11;
  options.max_samples = 100;
  const Json data = data_of(results, options);
  const auto frames = decoded<double>(data.at("animation").at("time"));
  ASSERT_EQ(frames.size(), 11U);
  EXPECT_EQ(frames.front(), results.time(0));
  EXPECT_EQ(frames.back(), results.time(10000));
  const auto time = decoded<double>(data.at("time"));
  EXPECT_LE(time.size(), 102U);
  EXPECT_TRUE(std::is_sorted(time.begin(), time.end()));
  EXPECT_EQ(time.back(), results.time(10000));
  const auto values = decoded<float>(data.at("values"));
  ASSERT_EQ(values.size(), 2 * time.size());
  const double offset = data.at("channels").at(1).at("offset");
  const auto second = values.begin() + static_cast<std::ptrdiff_t>(time.size());
  const auto [low, high] = std::minmax_element(second, values.end());
  EXPECT_FLOAT_EQ(static_cast<float>(*low + offset), -3);
  EXPECT_FLOAT_EQ(static_cast<float>(*high + offset), 7);
  EXPECT_NEAR(time[static_cast<std::size_t>(high - second)], results.time(4321), 2.1);
}

TEST_F(Report, HostileTextStaysText) {
  Results results = small_results();
  const std::string hostile =
      "</script><script>alert(1)</script><!-- <script> \xff \"quoted\" \\ $& %MIMBRE_DATA%";
  results.header.title = hostile;
  results.header.model_text = hostile;
  results.header.bodies[0].name = hostile;
  results.header.channels[0].name = hostile;
  results.summary_json = "{\"note\": \"<!--<script>\"}";
  const std::string html = report_html(results);
  EXPECT_EQ(data_text(html).find('<'), std::string::npos);
  EXPECT_THAT(html, testing::Not(HasSubstr("alert(1)</script>")));
  const Json data = data_of(results);
  EXPECT_THAT(data.at("title").text(),
              testing::StartsWith("</script><script>alert(1)</script><!-- <script> "));
  EXPECT_EQ(data.at("summary").at("note"), "<!--<script>");
}

TEST_F(Report, LoadsNothingFromElsewhere) {
  const std::string html = report_html(small_results());
  const char* load =
      R"re((src|href)\s*=\s*["']?\s*(https?:)?//|@import|url\(\s*["']?\s*(https?:)?//|<link)re";
  // The page's own elements and style; strings inside the bundled script are held back by the content policy.
  std::string outside = html;
  const std::size_t script = outside.rfind("<script>");
  outside.erase(script, outside.rfind("</script>") - script);
  EXPECT_THAT(test::matches(outside, load, true), testing::IsEmpty());
  EXPECT_THAT(html, HasSubstr("default-src 'none'"));
  for (const char* text : {"src=\"http", "href=\"http", "src='http", "href='http"})
    EXPECT_EQ(html.find(text), std::string::npos) << text;
}

TEST_F(Report, IsWhollyHtml) {
  const std::string html = report_html(small_results());
  EXPECT_EQ(html.rfind("<!doctype html>", 0), 0U);
  EXPECT_NE(html.find("</html>"), std::string::npos);
}

TEST_F(Report, ShownChannelsByName) {
  ReportOptions options;
  options.channels = {"arm.tip"};
  EXPECT_EQ(data_of(small_results(), options).at("shown"), (std::vector<double>{1}));
  options.channels = {"arm.tup"};
  try {
    report_html(small_results(), options);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no channel 'arm.tup' in the results (did you mean 'arm.tip'?)"));
  }
}

TEST_F(Report, RunsCutShortAndBrokenNumbers) {
  Results empty = small_results(0);
  EXPECT_EQ(data_of(empty).at("instants"), 0);
  Results broken = small_results();
  broken.channels(1, 0) = std::numeric_limits<double>::quiet_NaN();
  broken.channels(2, 0) = std::numeric_limits<double>::infinity();
  broken.poses[2](0, 0) = std::numeric_limits<double>::quiet_NaN();
  const Json data = data_of(broken);
  EXPECT_TRUE(std::isnan(decoded<float>(data.at("values"))[1]));
  EXPECT_EQ(data.at("channels").at(0).at("offset"), 1e6);
}

TEST_F(Report, ContradictorySizesAreRefused) {
  Results results = small_results();
  results.modes.resize(3, 2);
  EXPECT_THROW(report_html(results), InputError);
  results = small_results();
  results.poses.pop_back();
  EXPECT_THROW(report_html(results), InputError);
  results = small_results();
  results.header.bodies[1].lines = {{0, 2}};
  EXPECT_THROW(report_html(results), InputError);
}

/// A sheet of n × n points in a plane with one mode and its stress: as x, and ten times that at `hot`.
BodyDrawing sheet(int n, int hot) {
  BodyDrawing body;
  body.name = "sheet";
  body.modes = 2;
  body.points.resize(3, n * n);
  body.point_shapes.setZero(3 * n * n, 2);
  body.stress.setZero(6 * n * n, 1);  // as of a second-order body: of its first modes alone
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int k = i + n * j;
      body.points.col(k) << i, j, 0;
      body.point_shapes(3 * k + 2, 0) = k;
      body.stress(6 * k + 3, 0) = k == hot ? 10. * n : i;
      body.labels.push_back(1000 + k);
      if (i + 1 == n || j + 1 == n) continue;
      body.triangles.push_back({k, k + 1, k + 1 + n});
      body.triangles.push_back({k, k + 1 + n, k + n});
      body.lines.push_back({k, k + 1});
    }
  body.lines.push_back({0, n * n - 1});
  return body;
}

Results with_body(const BodyDrawing& body) {
  Results results = small_results();
  results.header.bodies.push_back(body);
  results.modes.conservativeResizeLike(Eigen::MatrixXd::Zero(3, 1 + body.modes));
  for (auto& poses : results.poses) {
    poses.conservativeResize(7, 3);
    poses.col(2) = poses.col(1);
  }
  return results;
}

TEST_F(Report, CarriesSurfacesAndStresses) {
  const BodyDrawing body = sheet(4, 6);
  const Json data = data_of(with_body(body)).at("bodies").at(2);
  EXPECT_EQ(decoded<float>(data.at("points")).size(), 48U);
  const auto triangles = decoded<std::uint32_t>(data.at("triangles"));
  ASSERT_EQ(triangles.size(), 3 * body.triangles.size());
  EXPECT_THAT(std::vector(triangles.begin(), triangles.begin() + 6), ElementsAre(0, 1, 5, 0, 5, 4));
  EXPECT_THAT(decoded<std::uint32_t>(data.at("lines")), ElementsAre(0, 15));  // that of no triangle
  EXPECT_EQ(decoded<std::uint32_t>(data.at("edges")).size(), 2U * 12);        // the sheet's border
  EXPECT_EQ(decoded<double>(data.at("labels")).at(6), 1006);
  const auto stress = decoded<float>(data.at("stress"));
  ASSERT_EQ(stress.size(), 6U * 16);
  EXPECT_EQ(stress[6 * 6 + 3], 40);
  EXPECT_EQ(stress[6 * 7 + 3], 3);
  const Json arm = data_of(small_results()).at("bodies").at(1);
  for (const char* none : {"triangles", "edges", "labels", "stress"}) EXPECT_EQ(arm.at(none).at("size"), 0);
}

TEST_F(Report, LargeSurfacesAreThinnedWithoutLosingHotSpots) {
  const int hot = 7777;
  const BodyDrawing body = sheet(120, hot);
  const Json data = data_of(with_body(body)).at("bodies").at(2);
  const auto labels = decoded<double>(data.at("labels"));
  ASSERT_LE(labels.size(), 2500U);
  ASSERT_GT(labels.size(), 1000U);
  const auto points = decoded<float>(data.at("points"));
  const auto shapes = decoded<float>(data.at("pointShapes"));
  const auto stress = decoded<float>(data.at("stress"));
  ASSERT_EQ(points.size(), 3 * labels.size());
  ASSERT_EQ(shapes.size(), 6 * labels.size());
  ASSERT_EQ(stress.size(), 6 * labels.size());
  bool found = false;
  for (std::size_t k = 0; k < labels.size(); ++k) {
    const int point = static_cast<int>(labels[k]) - 1000;
    EXPECT_EQ(points[3 * k], static_cast<float>(point % 120));
    EXPECT_EQ(shapes[3 * k + 2], static_cast<float>(point));
    EXPECT_EQ(stress[6 * k + 3], static_cast<float>(body.stress(6 * point + 3, 0)));
    found = found || point == hot;
  }
  EXPECT_TRUE(found);
}

TEST_F(Report, ContradictorySurfacesAreRefused) {
  const auto refused = [](auto&& change) {
    BodyDrawing body = sheet(4, 6);
    change(body);
    EXPECT_THROW(report_html(with_body(body)), InputError);
  };
  refused([](BodyDrawing& body) { body.triangles[0][1] = 16; });
  refused([](BodyDrawing& body) { body.triangles[0][1] = -1; });
  refused([](BodyDrawing& body) { body.labels.pop_back(); });
  refused([](BodyDrawing& body) { body.stress.setZero(6 * 15, 1); });
  refused([](BodyDrawing& body) { body.stress.setZero(6 * 16, 3); });
}

TEST_F(Report, IsWrittenWholeOrNotAtAll) {
  const auto folder =
      std::filesystem::path(testing::TempDir()) / ("mimbre_report_test_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const auto path = folder / "report.html";
  write_report(small_results(), path.string());
  std::ifstream file(path, std::ios::binary);
  const std::string written{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(written, report_html(small_results()));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
  EXPECT_THROW(write_report(small_results(), (folder / "missing" / "report.html").string()),
               std::runtime_error);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace mimbre::report_test
