#pragma once
#include <string>
#include <vector>

namespace mimbre::app {

/// A table for people: the first row is the heading. A column whose entries are numbers is aligned to the
/// right.
class Table {
 public:
  explicit Table(std::vector<std::string> heading) : rows_{std::move(heading)} {}
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
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
