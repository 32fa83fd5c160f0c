#include "support/report_data.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>

namespace mimbre::report_data {

Results small_results(int instants) {
  Results results;
  auto& header = results.header;
  header.title = "A pendulum";
  header.model_text = "mimbre: 1\n";
  header.options_json = R"({"length": 1.5})";
  header.step = 0.01;
  header.channels = {{"ball.z", "m", "height"}, {"arm.tip", "rad", "angle"}};
  BodyDrawing ball;
  ball.name = "ball";
  ball.shapes.push_back({spec::Shape::Kind::sphere, {}, {0.05, 0, 0}});
  BodyDrawing arm;
  arm.name = "arm";
  arm.points.resize(3, 2);
  arm.points << 0, 1.5, 0, 0, 0, 0;
  arm.point_shapes.resize(6, 1);
  arm.point_shapes << 0, 0, 0, 0, 0, 1;
  arm.lines = {{0, 1}};
  arm.line_radius = 0.02;
  arm.modes = 1;
  header.bodies = {ball, arm};
  RoadDrawing road;
  road.name = "track";
  road.profile.resize(2, 2);
  road.profile << 0, 10, 0.5, 0.25;
  header.roads = {road};
  results.summary_json = R"({"cpu_s": 0.25, "warnings": ["the step is large"]})";
  results.time.setLinSpaced(instants, 0, 0.01 * (instants - 1));
  results.channels.resize(instants, 2);
  results.modes.resize(instants, 1);
  for (int i = 0; i < instants; ++i) {
    results.channels.row(i) << 1e6 + std::sin(i), 0.125 * i;
    results.modes(i, 0) = 0.5 * i;
    Eigen::Matrix<double, 7, Eigen::Dynamic> poses(7, 2);
    poses.col(0) << 1e5 + 0.001 * i, 2, 3, 1, 0, 0, 0;
    poses.col(1) << 4, 5, 6, 0, 1, 0, 0;
    results.poses.push_back(poses);
  }
  return results;
}

std::vector<unsigned char> from_base64(const std::string& text) {
  static const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<unsigned char> bytes;
  unsigned bits = 0;
  int have = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<unsigned>(digits.find(c));
    have += 6;
    if (have < 8) continue;
    have -= 8;
    bytes.push_back(static_cast<unsigned char>(bits >> have));
  }
  return bytes;
}

template <typename T>
std::vector<T> decoded(const Json& array) {
  const auto bytes = from_base64(array.at("data"));
  EXPECT_EQ(bytes.size(), static_cast<std::size_t>(array.at("size").number()) * sizeof(T));
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}
template std::vector<double> decoded(const Json&);
template std::vector<float> decoded(const Json&);
template std::vector<std::uint32_t> decoded(const Json&);

std::string data_text(const std::string& html) {
  const std::string begin = R"(<script type="application/json" id="mimbre-data">)";
  const std::size_t at = html.find(begin) + begin.size();
  return html.substr(at, html.find("</script", at) - at);
}

}  // namespace mimbre::report_data
