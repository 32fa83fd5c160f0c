#include "urdf/yaml_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace mimbre::urdf {

std::string numbers(const std::vector<double>& values, double least) {
  double largest = 0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  std::string text = "[";
  for (std::size_t k = 0; k < values.size(); ++k) {
    const bool small = std::abs(values[k]) <= std::max(least, 1e-15 * largest);
    text += fmt::format("{}{:.15g}", k > 0 ? ", " : "", small ? 0.0 : values[k] + 0.0);
  }
  return text + "]";
}
std::string list(const Eigen::Vector3d& v, double least) { return numbers({v.x(), v.y(), v.z()}, least); }
std::string point(const Eigen::Vector3d& p) { return list(p, 1e-15); }
std::string number(double value) { return fmt::format("{:.15g}", value); }

std::string axes(const Eigen::Matrix3d& rotation) {
  if (rotation.isIdentity(1e-15)) return "";
  return fmt::format(", x: {}, y: {}", list(Eigen::Vector3d(rotation.col(0))),
                     list(Eigen::Vector3d(rotation.col(1))));
}

std::string yaml_word(const std::string& text) {
  const bool plain = !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '-' || c == '.' || c == '/' || c >= 0x80;
  }) && std::isalpha(static_cast<unsigned char>(text[0]));
  if (plain) return text;
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return result + "\"";
}

std::string comment(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20; }, ' ');
  return text;
}

}  // namespace mimbre::urdf
