#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "base/file_format.h"
#include "mimbre/diagnostics.h"
#include "mimbre/report.h"
#include "support/report_data.h"

namespace mimbre::modes_report_test {
namespace {

using report_data::data_text;
using report_data::decoded;
using report_data::Json;
using testing::ElementsAre;
using testing::FloatNear;
using testing::SizeIs;

constexpr double kTurn = 2 * std::numbers::pi;

/// Three point masses of 2 kg along x that springs of 200 N/m hold across, and one of them couples: two
/// modes.
ReducedBody three_masses() {
  ReducedBody body;
  body.name = "masses";
  body.modes = 2;
  body.mode_names = {"static ball.z", "dynamic 1"};
  body.mass = 6;
  body.first_moment = {6, 0, 0};  // at x = 0, 1, 2
  body.second_moment = Eigen::Vector3d(10, 0, 0).asDiagonal();
  body.S.setZero(3, 2);
  for (auto& block : body.S_position) block.setZero(3, 2);
  for (auto& row : body.S_modes)
    for (auto& block : row) block.setZero(2, 2);
  body.S_modes[2][2] = body.mass_matrix = 2 * Eigen::Matrix2d::Identity();
  body.S(2, 0) = body.S(2, 1) = 2;
  body.S_position[0](2, 0) = 4;
  body.S_position[0](2, 1) = 2;
  body.stiffness = (Eigen::Matrix2d() << 300, -100, -100, 300).finished();
  body.damping.setZero(2, 2);
  body.nodes.resize(3, 3);
  body.nodes << 0, 1, 2, 0, 0, 0, 0, 0, 0;
  body.node_shapes.setZero(9, 2);
  body.node_shapes(8, 0) = body.node_shapes(5, 1) = 1;
  body.lines = {{0, 1}, {1, 2}};
  BodyFrame frame;
  frame.name = "ball";
  frame.position = {2, 0, 0};
  frame.X.setZero(3, 2);
  frame.X(2, 0) = 1;
  frame.X_theta.setZero(3, 2);
  body.frames = {frame};
  body.checks = {{"mass", true, "6 kg"}, {"</script>", false, "free < full"}};
  make_orthogonal(body);
  return body;
}

class ModesReport : public testing::Test {
 protected:
  void SetUp() override {
    if (!report_available()) GTEST_SKIP() << "built without the report page";
  }
};

Json data_of(const ReducedBody& body) { return Json::parse(data_text(modes_html(body))); }

TEST_F(ModesReport, CarriesTheCertificateAndTheBody) {
  const Json data = data_of(three_masses());
  EXPECT_EQ(data.at("format"), "mimbre-modes-1");
  EXPECT_EQ(data.at("name"), "masses");
  EXPECT_EQ(data.at("checks").at(0), Json::parse(R"({"name": "mass", "passed": true, "detail": "6 kg"})"));
  EXPECT_EQ(data.at("checks").at(1).at("name"), "</script>");
  EXPECT_EQ(data.at("checks").at(1).at("passed"), false);
  EXPECT_EQ(data.at("mass"), 6);
  EXPECT_EQ(data.at("centre"), (std::vector<double>{1, 0, 0}));
  // Two of the masses are 1 m from the centre.
  EXPECT_EQ(data.at("inertia"), (std::vector<double>{0, 0, 0, 0, 4, 0, 0, 0, 4}));
  const Json& frame = data.at("frames").at(0);
  EXPECT_EQ(frame.at("name"), "ball");
  EXPECT_EQ(frame.at("position"), (std::vector<double>{2, 0, 0}));
  EXPECT_THAT(decoded<float>(frame.at("shapes")), SizeIs(6));
  EXPECT_THAT(decoded<std::uint32_t>(data.at("body").at("lines")), ElementsAre(0, 1, 1, 2));
}

/// The masses' own modes are in phase at √(200/2) and against each other at √(400/2) rad/s.
TEST_F(ModesReport, HasTheEigenmodesAndThoseOfTheUser) {
  const Json data = data_of(three_masses());
  ASSERT_THAT(data.at("families"), SizeIs(2));
  const Json &own = data.at("families").at(0), &user = data.at("families").at(1);
  EXPECT_NEAR(own.at("modes").at(0).at("frequency").number(), 10 / kTurn, 1e-9);
  EXPECT_NEAR(own.at("modes").at(1).at("frequency").number(), std::sqrt(200) / kTurn, 1e-9);
  EXPECT_THAT(decoded<float>(own.at("amplitudes")), ElementsAre(1, 0, 0, 1));
  EXPECT_EQ(user.at("modes").at(0).at("name"), "static ball.z");
  EXPECT_EQ(user.at("modes").at(1).at("name"), "dynamic 1");
  for (const Json& mode : user.at("modes"))
    EXPECT_NEAR(mode.at("frequency").number(), std::sqrt(150) / kTurn, 1e-9);
  // The user's modes move one mass by 1 m each, by whatever amplitudes.
  const auto shapes = decoded<float>(data.at("body").at("pointShapes"));
  const auto amplitudes = decoded<float>(user.at("amplitudes"));
  ASSERT_EQ(shapes.size(), 18U);
  ASSERT_EQ(amplitudes.size(), 4U);
  for (std::size_t mode = 0; mode < 2; ++mode) {
    const auto z = [&](std::size_t node) {
      return amplitudes[2 * mode] * shapes[3 * node + 2] +
             amplitudes[2 * mode + 1] * shapes[9 + 3 * node + 2];
    };
    EXPECT_THAT((std::array{z(0), z(1), z(2)}),
                ElementsAre(0, FloatNear(mode == 1, 1e-6F), FloatNear(mode == 0, 1e-6F)));
  }
}

TEST_F(ModesReport, ABodyWhoseAmplitudesAreTheUsersHasOneFamily) {
  ReducedBody body = three_masses();
  body.user_from_modal.setIdentity(2, 2);
  const Json data = data_of(body);
  ASSERT_THAT(data.at("families"), SizeIs(1));
  EXPECT_EQ(data.at("families").at(0).at("modes").at(0).at("name"), "static ball.z");
}

TEST_F(ModesReport, DegenerateBodiesHaveAPage) {
  ReducedBody body;
  body.name = "rigid";
  const Json data = data_of(body);
  EXPECT_THAT(data.at("families").at(0).at("modes"), SizeIs(0));
  EXPECT_TRUE(data.at("centre").at(0).is_null());
  EXPECT_THAT(data.at("checks"), SizeIs(0));
}

TEST_F(ModesReport, ContradictionsAreRefused) {
  ReducedBody body = three_masses();
  body.triangles = {{0, 1, 3}};
  EXPECT_THROW(modes_html(body), InputError);
  body = three_masses();
  body.stress.setZero(17, 2);
  EXPECT_THROW(modes_html(body), InputError);
}

TEST(FileFormat, TellsBodiesFromResults) {
  const auto folder = std::filesystem::path(testing::TempDir());
  const std::string of = "format_" + std::to_string(getpid()), body = (folder / (of + "_body.h5")).string(),
                    results = (folder / (of + "_run.h5")).string();
  save(three_masses(), body);
  ResultsWriter(results, {}).finish("");
  EXPECT_TRUE(hdf5::file_format(body).starts_with("mimbre-reduced-body-"));
  EXPECT_TRUE(hdf5::file_format(results).starts_with("mimbre-results-"));
  EXPECT_EQ(hdf5::file_format((folder / "missing.h5").string()), "");
  EXPECT_EQ(hdf5::file_format(MIMBRE_SOURCE_DIR "/CMakeLists.txt"), "");
  std::filesystem::remove(body);
  std::filesystem::remove(results);
}

}  // namespace
}  // namespace mimbre::modes_report_test
