#include "mimbre/vtk.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace mimbre::test::vtk_test {
namespace {

namespace fs = std::filesystem;

/// A triangle with one mode that lifts and pulls its second point, and a bare line; the body turns about z.
Results small_run() {
  Results r;
  BodyDrawing plate;
  plate.name = "plate/one & two";
  plate.modes = 1;
  plate.points.resize(3, 3);
  plate.points << 0, 1, 0, 0, 0, 1, 0, 0, 0;
  plate.point_shapes = Eigen::MatrixXd::Zero(9, 1);
  plate.point_shapes(5, 0) = 2;
  plate.triangles = {{0, 1, 2}};
  plate.labels = {11, 12, 13};
  plate.stress = Eigen::MatrixXd::Zero(18, 1);
  plate.stress(9, 0) = 1e6;  // shear of the second point
  BodyDrawing bar;
  bar.name = "bar";
  bar.points.resize(3, 2);
  bar.points << 0, 0, 0, 0, 0, 1;
  bar.point_shapes.resize(6, 0);
  bar.lines = {{0, 1}};
  r.header.bodies = {plate, bar};
  constexpr int instants = 5;
  r.time = Eigen::VectorXd::LinSpaced(instants, 0, 1);
  r.modes = Eigen::MatrixXd::Zero(instants, 1);
  r.modes.col(0) << 0, -3, 1, 0, 2;
  for (int k = 0; k < instants; ++k) {
    Eigen::Matrix<double, 7, Eigen::Dynamic> poses(7, 2);
    poses.col(0) << 10, 0, 0, std::sqrt(0.5), 0, 0, std::sqrt(0.5);
    poses.col(1) << 0, 0, k, 1, 0, 0, 0;
    r.poses.push_back(poses);
  }
  return r;
}

std::string text_of(const fs::path& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::vector<unsigned char> decoded(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<unsigned char> bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<std::uint32_t>(digits.find(c));
    count += 6;
    if (count >= 8) bytes.push_back(static_cast<unsigned char>(bits >> (count -= 8)));
  }
  return bytes;
}

template <typename Number>
std::vector<Number> array(const std::string& file, const std::string& name) {
  const auto at = file.find("Name=\"" + name + "\"");
  if (at == std::string::npos) return {};
  const auto begin = file.find('>', at) + 1;
  const auto bytes = decoded(file.substr(begin, file.find('<', begin) - begin));
  std::uint64_t size = 0;
  std::memcpy(&size, bytes.data(), sizeof size);
  EXPECT_EQ(size + sizeof size, bytes.size()) << name;
  std::vector<Number> values(size / sizeof(Number));
  if (size > 0) std::memcpy(values.data(), bytes.data() + sizeof size, size);
  return values;
}

TEST(Vtk, HasTheMotionDeflectionAndStressOfEveryInstant) {
  const fs::path folder =
      fs::path(testing::TempDir()) / ("mimbre-vtk-" + std::to_string(getpid())) / "deeper";
  fs::remove_all(folder);
  const std::string path = write_vtk(small_run(), folder.string());
  const std::string list = text_of(path);
  EXPECT_NE(list.find("timestep=\"0.25\" part=\"0\" name=\"plate/one &amp; two\" "
                      "file=\"plate_one___two_00001.vtp\""),
            std::string::npos)
      << list;
  const std::string plate = text_of(folder / "plate_one___two_00001.vtp");
  const auto points = array<float>(plate, "points");
  ASSERT_EQ(points.size(), 9u);
  // Turned by a right angle: x to y, and lifted by 2 · (−3).
  EXPECT_NEAR(points[3], 10, 1e-6);
  EXPECT_NEAR(points[4], 1, 1e-6);
  EXPECT_NEAR(points[5], -6, 1e-6);
  EXPECT_NEAR(array<float>(plate, "displacement")[5], -6, 1e-6);
  EXPECT_NEAR(array<float>(plate, "von_mises")[1], 3e6 * std::sqrt(3), 1);
  EXPECT_NEAR(array<float>(plate, "stress")[9], -3e6, 1);
  EXPECT_EQ(array<std::int64_t>(plate, "node")[2], 13);
  EXPECT_EQ(array<std::int32_t>(plate, "connectivity"), std::vector<std::int32_t>{});  // no lines
  const std::string last = text_of(folder / "plate_one___two_00004.vtp");
  EXPECT_NEAR(array<float>(last, "von_mises_max")[1], 3e6 * std::sqrt(3), 1);
  EXPECT_TRUE(fs::exists(folder / "bar_00004.vtp"));
  fs::remove_all(folder.parent_path());
}

TEST(Vtk, TakesInstantsEvenlyAndSaysWhereItCannotWrite) {
  const fs::path folder = fs::path(testing::TempDir()) / ("mimbre-vtk-few-" + std::to_string(getpid()));
  fs::remove_all(folder);
  VtkOptions options;
  options.most_instants = 2;
  const std::string list = text_of(write_vtk(small_run(), folder.string(), options));
  EXPECT_NE(list.find("timestep=\"1\""), std::string::npos);
  EXPECT_EQ(list.find("timestep=\"0.5\""), std::string::npos);
  EXPECT_FALSE(fs::exists(folder / "bar_00002.vtp"));
  std::ofstream(folder / "file") << "x";
  try {
    write_vtk(small_run(), (folder / "file" / "below").string());
    ADD_FAILURE();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("below"), std::string::npos) << error.what();
  }
  fs::remove_all(folder);
}

}  // namespace
}  // namespace mimbre::test::vtk_test
