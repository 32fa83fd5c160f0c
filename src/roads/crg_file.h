#pragma once
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "mimbre/diagnostics.h"
#include "mimbre/road_file.h"

/// The form of OpenCRG files: a head of named blocks, `$$$$`, and rows of numbers.
namespace mimbre::roads {

/// A file's bytes, line by line.
struct Lines {
  std::string_view bytes;
  std::string name;
  std::size_t next_byte = 0;
  int number = 0;

  /// False at the end. Without what ends the line.
  bool next(std::string_view& line);
  Mark mark() const { return {name, number, 1}; }
  [[noreturn]] void fail(std::string message) const { throw InputError(mark(), std::move(message)); }
};

/// One of the columns behind D: in the block $KD_DEFINITION.
struct CrgColumn {
  enum Kind { section_at, section_numbered, x, y, phi, banking, slope, other };
  Kind kind = other;
  double number = 0;  ///< v of a long section in m, or its number
};

struct CrgHead {
  std::map<std::string, double> numbers;  ///< of the block $ROAD_CRG, by lower-case key
  std::map<std::string, Mark> marks;
  bool long_records = false, doubles = false,
       text = false;  ///< each row a record of its own; 8 bytes; formatted
  std::vector<CrgColumn> columns;
  std::vector<std::string> unused;
};

/// Up to the line $$$$, which it takes.
CrgHead read_crg_head(Lines& lines);

/// The rows behind the head, one after the other; what is missing is not a number.
std::vector<double> read_crg_rows(Lines& lines, const CrgHead& head);

/// read_road_grid, of bytes at hand.
RoadGrid parse_road_grid(std::string_view bytes, const std::string& name);

}  // namespace mimbre::roads
