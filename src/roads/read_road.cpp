#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "fe_files/text_file.h"
#include "math/elementary.h"
#include "roads/crg_file.h"

namespace mimbre {
namespace roads {
namespace {

/// Heights and lines are some km at most; what is larger would only overflow later.
constexpr double largest_value = 1e9;

/// For each place the nearest known one; the number of places where none is known.
std::vector<std::size_t> nearest_known(const std::vector<bool>& is_known) {
  const std::size_t count = is_known.size();
  std::vector<std::size_t> nearest(count, count);
  std::size_t last = count;
  for (std::size_t k = 0; k < count; ++k) nearest[k] = last = is_known[k] ? k : last;
  last = count;
  for (std::size_t k = count; k-- > 0;) {
    if (is_known[k]) last = k;
    if (nearest[k] == count || (last < count && last - k < k - nearest[k])) nearest[k] = last;
  }
  return nearest;
}

class Reading {
 public:
  Reading(std::string_view bytes, const std::string& name)
      : lines_{bytes, name}, head_(read_crg_head(lines_)), columns_(head_.columns.size()) {}

  RoadGrid read() {
    read_sections();
    rows_ = read_crg_rows(lines_, head_);
    count_rows();
    read_line();
    read_height_of_line();
    read_bank();
    read_heights();
    fill_gaps();
    road_.unused = head_.unused;
    return std::move(road_);
  }

 private:
  std::optional<double> number(const std::string& key) const {
    const auto found = head_.numbers.find(key);
    return found == head_.numbers.end() ? std::nullopt : std::optional(found->second);
  }
  double number_or(const std::string& key, double otherwise) const { return number(key).value_or(otherwise); }
  [[noreturn]] void fail(const std::string& key, std::string message) const {
    const auto found = head_.marks.find(key);
    throw InputError(found == head_.marks.end() ? Mark{lines_.name, 0, 0} : found->second,
                     std::move(message));
  }

  /// Place of the column in a row.
  std::optional<std::size_t> column(CrgColumn::Kind kind) const {
    for (std::size_t k = 0; k < columns_; ++k)
      if (head_.columns[k].kind == kind) return k;
    return std::nullopt;
  }
  double at(std::size_t row, std::size_t column) const { return rows_[row * columns_ + column]; }
  /// A number of the reference line, which must be known.
  double known(std::size_t row, std::size_t column, const char* what) const {
    const double value = at(row, column);
    if (!(std::abs(value) < largest_value))
      fail("", fmt::format("the row {} of the data has no {} of the reference line", row + 1, what));
    return value;
  }

  /// Places of the long sections across the road, and the order of their columns.
  void read_sections() {
    std::vector<double> numbers;
    bool at_places = false, numbered = false;
    for (std::size_t k = 0; k < columns_; ++k) {
      const CrgColumn& c = head_.columns[k];
      if (c.kind != CrgColumn::section_at && c.kind != CrgColumn::section_numbered) continue;
      (c.kind == CrgColumn::section_at ? at_places : numbered) = true;
      sections_.push_back(k);
      numbers.push_back(c.number);
    }
    if (sections_.size() < 2) fail("", "has less than two long sections: no surface");
    if (at_places && numbered) fail("", "some long sections have numbers, others places v");
    std::vector<std::size_t> order(sections_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return numbers[a] < numbers[b]; });
    std::vector<std::size_t> sorted;
    for (const std::size_t k : order) {
      sorted.push_back(sections_[k]);
      road_.v.push_back(numbers[k]);
    }
    sections_ = std::move(sorted);
    if (numbered) place_numbered();
    for (std::size_t k = 1; k < road_.v.size(); ++k)
      if (!(road_.v[k] - road_.v[k - 1] > 1e-6))
        fail("", fmt::format("two long sections are at v = {} m", road_.v[k]));
  }

  void place_numbered() {
    const std::size_t count = road_.v.size();
    for (std::size_t k = 0; k < count; ++k)
      if (road_.v[k] != static_cast<double>(k + 1))
        fail("", fmt::format("the long section {} is missing: they count from 1 to {}", k + 1, count));
    const auto right = number("long_section_v_right"), left = number("long_section_v_left");
    const double gaps = static_cast<double>(count - 1);
    double increment = number_or("long_section_v_increment", 0);
    if (increment == 0 && right && left) increment = (*left - *right) / gaps;
    if (!(increment > 0))
      fail("long_section_v_increment",
           "long sections without places need LONG_SECTION_V_INCREMENT above 0, or V_RIGHT and V_LEFT");
    const double first = right ? *right : left ? *left - increment * gaps : -increment * gaps / 2;
    if (left && std::abs(first + increment * gaps - *left) > 1e-3 * increment * std::max(gaps, 1.0))
      fail("long_section_v_left",
           fmt::format("LONG_SECTION_V_LEFT is {}, but {} sections {} m apart end at {}", *left, count,
                       increment, first + increment * gaps));
    for (std::size_t k = 0; k < count; ++k) road_.v[k] = first + increment * static_cast<double>(k);
  }

  void count_rows() {
    if (rows_.size() % columns_ != 0 && head_.long_records)
      fail("", fmt::format("the data end within a row of {} numbers", columns_));
    count_ = rows_.size() / columns_;
    road_.start_u = number_or("reference_line_start_u", 0);
    road_.increment = number_or("reference_line_increment", 0.01);
    if (!(road_.increment > 1e-6))
      fail("reference_line_increment", "REFERENCE_LINE_INCREMENT must be above 0");
    if (const auto end = number("reference_line_end_u")) {
      const double rows = (*end - road_.start_u) / road_.increment + 1, wanted = std::round(rows);
      if (!(wanted >= 2) || std::abs(rows - wanted) > 1e-3 * wanted)
        fail("reference_line_end_u",
             fmt::format("REFERENCE_LINE_END_U is {}, which no steps of {} m from {} lead to", *end,
                         road_.increment, road_.start_u));
      if (wanted > static_cast<double>(count_))
        fail("reference_line_end_u",
             fmt::format("the data have {} rows; {} are needed up to REFERENCE_LINE_END_U", count_, wanted));
      // What fills up the last record is none.
      count_ = static_cast<std::size_t>(wanted);
    } else {
      while (count_ > 0 && std::all_of(sections_.begin(), sections_.end(),
                                       [&](std::size_t k) { return std::isnan(at(count_ - 1, k)); }))
        --count_;
    }
    if (count_ < 2) fail("", "has less than two rows of data: no surface");
  }

  /// The sum of steps from the start, and where the end is given also of those back from there, each counting
  /// the more the nearer its own end is.
  std::vector<double> integrated(double start, std::optional<double> end,
                                 const std::vector<double>& steps) const {
    std::vector<double> sum(count_, start);
    for (std::size_t i = 1; i < count_; ++i) sum[i] = sum[i - 1] + steps[i];
    if (!end) return sum;
    const double error = *end - sum.back();
    for (std::size_t i = 0; i < count_; ++i)
      sum[i] += error * static_cast<double>(i) / static_cast<double>(count_ - 1);
    return sum;
  }

  /// Headings are those of the way to a point from the one before, so that the first has none.
  void read_line() {
    const double x = number_or("reference_line_start_x", 0), y = number_or("reference_line_start_y", 0);
    const auto end_x = number("reference_line_end_x"), end_y = number("reference_line_end_y");
    const auto xs = column(CrgColumn::x), ys = column(CrgColumn::y), phi = column(CrgColumn::phi);
    if (xs && ys && !phi) {
      for (std::size_t i = 0; i < count_; ++i) {
        road_.x.push_back(known(i, *xs, "x"));
        road_.y.push_back(known(i, *ys, "y"));
      }
    } else {
      double heading = number_or("reference_line_start_phi", 0);
      const bool closed = end_x && end_y;
      if (!phi && closed && !number("reference_line_start_phi") && (*end_x != x || *end_y != y))
        heading = mimbre::atan2(*end_y - y, *end_x - x);
      std::vector<double> dx(count_), dy(count_);
      for (std::size_t i = 1; i < count_; ++i) {
        if (phi) heading = known(i, *phi, "phi");
        dx[i] = road_.increment * mimbre::cos(heading);
        dy[i] = road_.increment * mimbre::sin(heading);
      }
      road_.x = integrated(x, closed && phi ? end_x : std::nullopt, dx);
      road_.y = integrated(y, closed && phi ? end_y : std::nullopt, dy);
    }
    for (std::size_t i = 1; i < count_; ++i) {
      const double length = mimbre::hypot(road_.x[i] - road_.x[i - 1], road_.y[i] - road_.y[i - 1]);
      if (!(std::abs(length - road_.increment) < 0.1 * road_.increment))
        fail("reference_line_increment",
             fmt::format(
                 "the reference line's points {} and {} are {} m apart, not {} m: its end is another than "
                 "its headings lead to",
                 i, i + 1, length, road_.increment));
      if (i >= 2 && !((road_.x[i] - road_.x[i - 1]) * (road_.x[i - 1] - road_.x[i - 2]) +
                          (road_.y[i] - road_.y[i - 1]) * (road_.y[i - 1] - road_.y[i - 2]) >
                      0))
        fail("", fmt::format("the reference line turns by more than 90 degrees at its point {}", i));
    }
  }

  void read_height_of_line() {
    const auto slopes = column(CrgColumn::slope);
    std::vector<double> steps(count_);
    for (std::size_t i = 1; i < count_; ++i)
      steps[i] =
          road_.increment * (slopes ? known(i, *slopes, "slope") : number_or("reference_line_start_s", 0));
    road_.line_height = integrated(number_or("reference_line_start_z", 0),
                                   slopes ? number("reference_line_end_z") : std::nullopt, steps);
  }

  void read_bank() {
    const auto banks = column(CrgColumn::banking);
    road_.bank.assign(count_, number_or("reference_line_start_b", 0));
    if (banks)
      for (std::size_t i = 0; i < count_; ++i) road_.bank[i] = known(i, *banks, "banking");
  }

  void read_heights() {
    road_.height.reserve(count_ * sections_.size());
    for (std::size_t i = 0; i < count_; ++i)
      for (const std::size_t k : sections_) {
        const double height = at(i, k);
        if (std::isfinite(height) && std::abs(height) > largest_value)
          fail("", fmt::format("the row {} of the data has a height of {} m", i + 1, height));
        road_.height.push_back(std::isfinite(height) ? height : std::nan(""));
      }
  }

  /// By the nearest that is known, first across, then along.
  void fill_gaps() {
    const std::size_t across = sections_.size();
    std::vector<bool> row_known(count_);
    road_.right.assign(count_, road_.v.front());
    road_.left.assign(count_, road_.v.back());
    for (std::size_t i = 0; i < count_; ++i) {
      double* row = road_.height.data() + i * across;
      std::vector<bool> is_known(across);
      for (std::size_t k = 0; k < across; ++k) is_known[k] = std::isfinite(row[k]);
      const std::vector<std::size_t> from = nearest_known(is_known);
      row_known[i] = from[0] < across;
      if (row_known[i]) {
        road_.right[i] = road_.v[from[0]];
        road_.left[i] = road_.v[from[across - 1]];
      }
      for (std::size_t k = 0; k < across; ++k) {
        if (is_known[k]) continue;
        ++road_.gaps;
        if (!row_known[i]) continue;
        row[k] = row[from[k]];
        road_.holes += k > from[0] && k < from[across - 1] ? 1 : 0;
      }
    }
    const std::vector<std::size_t> from = nearest_known(row_known);
    if (from[0] == count_) fail("", "knows no height at all");
    for (std::size_t i = 0; i < count_; ++i) {
      if (row_known[i]) continue;
      road_.holes += across;
      for (std::size_t k = 0; k < across; ++k)
        road_.height[i * across + k] = road_.height[from[i] * across + k];
    }
    if (road_.gaps == 0) road_.right = road_.left = {};
  }

  Lines lines_;
  CrgHead head_;
  std::size_t columns_, count_ = 0;
  std::vector<std::size_t> sections_;  ///< columns of the long sections, from right to left
  std::vector<double> rows_;
  RoadGrid road_;
};

}  // namespace

RoadGrid parse_road_grid(std::string_view bytes, const std::string& name) {
  return Reading(bytes, name).read();
}

}  // namespace roads

RoadGrid read_road_grid(const std::filesystem::path& path) {
  const std::string bytes = fe::read_bytes(path.string());
  return roads::parse_road_grid(bytes, path.string());
}

}  // namespace mimbre
