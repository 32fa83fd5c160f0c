#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

#include "fe_files/text.h"
#include "roads/crg_file.h"

namespace mimbre::roads {
namespace {

constexpr double missing = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t record = 80;  ///< bytes

/// Fields of 10 or 20 characters, 80 in a line. Of long records each row begins a line.
std::vector<double> read_text(Lines& lines, const CrgHead& head) {
  const std::size_t width = head.doubles ? 20 : 10, in_line = record / width, columns = head.columns.size();
  std::vector<double> rows;
  std::string_view line;
  while (lines.next(line)) {
    if (line.find_first_not_of(" \t") == std::string_view::npos) continue;
    std::size_t fields = 0;
    while (fields < in_line && fields * width < line.size()) {
      const std::string_view field = fe::trimmed(line.substr(fields * width, width));
      // Blanks fill the last line.
      if (field.empty()) break;
      const bool unknown = field.front() == '*' || fe::lower(field) == "nan";
      const auto number = unknown ? std::optional<double>(missing) : fe::to_real(field);
      if (!number)
        lines.fail(fmt::format("'{}' in the columns {} to {} is no number", fe::shown(field),
                               fields * width + 1, (fields + 1) * width));
      rows.push_back(*number);
      ++fields;
      if (head.long_records && rows.size() % columns == 0) break;
    }
    if (head.long_records && fields < in_line && rows.size() % columns != 0)
      lines.fail(fmt::format("the row ends with its field {} of {}", rows.size() % columns, columns));
  }
  return rows;
}

template <class Real, class Bits>
double number_at(const char* bytes) {
  Bits bits = 0;
  for (std::size_t k = 0; k < sizeof(Bits); ++k)
    bits = static_cast<Bits>(bits << 8 | static_cast<unsigned char>(bytes[k]));
  return static_cast<double>(std::bit_cast<Real>(bits));
}

/// Numbers of 4 or 8 bytes, the highest first.
std::vector<double> read_binary(const Lines& lines, const CrgHead& head) {
  const std::size_t size = head.doubles ? 8 : 4, columns = head.columns.size();
  const std::string_view data = lines.bytes.substr(std::min(lines.next_byte, lines.bytes.size()));
  std::size_t stride = size * columns;
  if (head.long_records) stride = (stride + record - 1) / record * record;
  const std::size_t count = data.size() / stride;
  std::vector<double> rows;
  rows.reserve(count * columns);
  for (std::size_t row = 0; row < count; ++row)
    for (std::size_t column = 0; column < columns; ++column) {
      const char* place = data.data() + row * stride + column * size;
      rows.push_back(head.doubles ? number_at<double, std::uint64_t>(place)
                                  : number_at<float, std::uint32_t>(place));
    }
  return rows;
}

}  // namespace

std::vector<double> read_crg_rows(Lines& lines, const CrgHead& head) {
  return head.text ? read_text(lines, head) : read_binary(lines, head);
}

}  // namespace mimbre::roads
