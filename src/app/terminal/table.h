#pragma once
#include <string>
#include <vector>

namespace mimbre::app {

/// A table for people: the first row is the heading. A column whose entries are numbers is aligned to the
/// right.
class Table {
 public:
  explicit Table(std::vector<std::string> heading) : rows_{std::move(heading)} {}
  /// What of the cells is not fit for a terminal is made visible.
  void add(std::vector<std::string> row);
  /// Columns padded with blanks, two blanks between them, one line per row.
  std::string text() const;
  /// The same as a Markdown table.
  std::string markdown() const;

 private:
  std::vector<std::size_t> widths() const;
  std::vector<bool> numeric() const;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace mimbre::app
