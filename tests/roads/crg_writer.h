#pragma once
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

/// Writes roads as OpenCRG files, and says what the files mean without the readers of src/roads.
namespace mimbre::test {

/// Rows along, sections across; all in m, rad and m/m.
struct RoadSketch {
  double start_u = 0, start_x = 0, start_y = 0, start_z = 0, start_phi = 0, increment = 1;
  std::vector<double> phi;  ///< heading from row i − 1 to row i; the first is not used; empty: straight
  std::vector<double> slope, bank;  ///< of each row, or empty
  std::vector<double> v;
  std::vector<double> height;  ///< NaN: missing
  bool numbered = false;       ///< sections by number and increment, not by place

  std::size_t rows() const { return height.size() / v.size(); }
};

/// `form`: one of LRFI, LDFI, KRFI, KDFI, KRBI, KDBI, LRBI, LDBI.
inline std::string written(const RoadSketch& road, const std::string& form) {
  const std::size_t across = road.v.size(), rows = road.rows();
  std::string out = fmt::format(
      "$CT\na road of the tests\n$ROAD_CRG\nREFERENCE_LINE_START_U = {}\nREFERENCE_LINE_START_X = {}\n"
      "REFERENCE_LINE_START_Y = {}\nREFERENCE_LINE_START_Z = {}\nREFERENCE_LINE_START_PHI = {}\n"
      "REFERENCE_LINE_END_U = {}\nREFERENCE_LINE_INCREMENT = {}\nLONG_SECTION_V_RIGHT = {}\n"
      "LONG_SECTION_V_LEFT = {}\n",
      road.start_u, road.start_x, road.start_y, road.start_z, road.start_phi,
      road.start_u + road.increment * static_cast<double>(rows - 1), road.increment, road.v.front(),
      road.v.back());
  if (road.numbered) out += fmt::format("LONG_SECTION_V_INCREMENT = {}\n", road.v[1] - road.v[0]);
  out += "$KD_Definition\n#:" + form + "\n";
  if (!road.phi.empty()) out += "D:reference line phi,rad\n";
  if (!road.bank.empty()) out += "D:reference line banking,m/m\n";
  if (!road.slope.empty()) out += "D:reference line slope,m/m\n";
  for (std::size_t k = 0; k < across; ++k)
    out += road.numbered ? fmt::format("D:long section {},m\n", k + 1)
                         : fmt::format("D:long section at v = {},m\n", road.v[k]);
  out += std::string(80, '$') + "\n";

  std::vector<double> numbers;
  std::size_t columns = 0;
  const double missing = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < rows; ++i) {
    if (!road.phi.empty()) numbers.push_back(i > 0 ? road.phi[i] : missing);
    if (!road.bank.empty()) numbers.push_back(road.bank[i]);
    if (!road.slope.empty()) numbers.push_back(i > 0 ? road.slope[i] : missing);
    for (std::size_t k = 0; k < across; ++k) numbers.push_back(road.height[i * across + k]);
    if (i == 0) columns = numbers.size();
  }
  const bool long_records = form[0] == 'L', doubles = form[1] == 'D', text = form[2] == 'F';
  const std::size_t size = text ? (doubles ? 20 : 10) : (doubles ? 8 : 4);
  std::size_t in_record = 0;
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    if (text) {
      out += std::isnan(numbers[k]) ? fmt::format("{:>{}}", "*missing*", size)
                                    : fmt::format("{:{}.{}f}", numbers[k], size, doubles ? 15 : 7);
    } else {
      const std::uint64_t bits = doubles ? std::bit_cast<std::uint64_t>(numbers[k])
                                         : std::bit_cast<std::uint32_t>(static_cast<float>(numbers[k]));
      for (std::size_t byte = size; byte-- > 0;) out += static_cast<char>(bits >> (8 * byte) & 0xff);
    }
    in_record += size;
    const bool row_ends = long_records && (k + 1) % columns == 0, file_ends = k + 1 == numbers.size();
    if (text && (in_record == 80 || row_ends || file_ends)) {
      out += '\n';
      in_record = 0;
    } else if (!text && (row_ends || file_ends)) {
      out.append((80 - in_record % 80) % 80, '\0');
      in_record = 0;
    }
  }
  return out;
}

struct RoadPlace {
  double x = 0, y = 0, z = 0;
};

/// What a file says, by ASAM OpenCRG 1.2: the line goes on by an increment in each row's heading; where it
/// bends, a row's points stand on the perpendicular of the chord between the points before and behind, as far
/// out as lies v beside the segments; between the rows, lines of constant v are straight and heights
/// bilinear.
class RoadMeaning {
 public:
  explicit RoadMeaning(const RoadSketch& road) : road_(road) {
    double x = road.start_x, y = road.start_y, z = road.start_z;
    for (std::size_t i = 0; i < road.rows(); ++i) {
      if (i > 0) {
        const double heading = road.phi.empty() ? road.start_phi : road.phi[i];
        x += road.increment * std::cos(heading);
        y += road.increment * std::sin(heading);
        if (!road.slope.empty()) z += road.increment * road.slope[i];
      }
      line_.push_back({x, y, z});
    }
  }

  /// Row i, section at v, which needs to be none of the file's.
  RoadPlace point(std::size_t i, double v) const {
    const std::size_t last = road_.rows() - 1;
    const RoadPlace &before = line_[i > 0 ? i - 1 : 0], &behind = line_[i < last ? i + 1 : last];
    const RoadPlace &a = line_[i > 0 ? i - 1 : 0], &b = line_[i > 0 ? i : 1];
    const double chord = std::atan2(behind.y - before.y, behind.x - before.x),
                 segment = std::atan2(b.y - a.y, b.x - a.x);
    const double out = v / std::cos(chord - segment);
    return {line_[i].x - out * std::sin(chord), line_[i].y + out * std::cos(chord), height(i, v)};
  }

  /// The share f of the way from row i to the next. Bank times v is bilinear, too.
  RoadPlace between(std::size_t i, double f, double v) const {
    const RoadPlace a = point(i, v), b = point(i + 1, v);
    return {(1 - f) * a.x + f * b.x, (1 - f) * a.y + f * b.y, (1 - f) * a.z + f * b.z};
  }

 private:
  double bank(std::size_t i) const { return road_.bank.empty() ? 0 : road_.bank[i]; }
  double height(std::size_t i, double v) const {
    std::size_t k = 0;
    while (k + 2 < road_.v.size() && road_.v[k + 1] <= v) ++k;
    const double* row = road_.height.data() + i * road_.v.size();
    const double share = (v - road_.v[k]) / (road_.v[k + 1] - road_.v[k]);
    return line_[i].z + bank(i) * v + (1 - share) * row[k] + share * row[k + 1];
  }

  RoadSketch road_;
  std::vector<RoadPlace> line_;
};

/// The kinds of ASAM's hand-made roads: 22 m long, 3 m wide, 1 m along, 0.25 to 1 m across, with boards of
/// 11 to 33 mm on it. `turn`: of the heading in each metre.
inline RoadSketch handmade_road(double turn, bool banked, bool sloped) {
  RoadSketch road;
  road.v = {-1.5, -1.25, -1, 0, 1, 1.25, 1.5};
  std::mt19937 random(11);
  for (std::size_t i = 0; i < 23; ++i) {
    const double s = static_cast<double>(i);
    if (turn != 0) road.phi.push_back(turn * s + 0.3 * std::sin(0.5 * s));
    if (banked) road.bank.push_back(0.08 * std::sin(0.4 * s));
    if (sloped) road.slope.push_back(0.1 * std::cos(0.3 * s));
    for (std::size_t k = 0; k < road.v.size(); ++k)
      road.height.push_back(0.0111111 * static_cast<double>(random() % 4));
  }
  return road;
}

/// A curved road with half a cylinder of 50 mm across it, 1 cm fine along: about 120 kB as LRFI.
inline RoadSketch half_round_road() {
  RoadSketch road;
  road.increment = 0.01;
  road.v = {-1.5, -1.0, -0.5, 0, 0.5, 1.0, 1.5};
  constexpr std::size_t rows = 1450;
  for (std::size_t i = 0; i < rows; ++i) {
    const double u = 0.01 * static_cast<double>(i), aside = u - 7.2;
    road.phi.push_back(0.15 * u);
    const double height = std::abs(aside) < 0.05 ? std::sqrt(0.0025 - aside * aside) : 0;
    for (std::size_t k = 0; k < road.v.size(); ++k) road.height.push_back(height);
  }
  return road;
}

}  // namespace mimbre::test
