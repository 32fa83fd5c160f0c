#include "app/terminal/table.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "mimbre/text.h"

namespace mimbre::app {
namespace {

/// Characters rather than bytes of UTF-8.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string padded(const std::string& text, std::size_t to, bool right) {
  const std::string blanks(to - width(text), ' ');
  return right ? blanks + text : text + blanks;
}

bool is_number(const std::string& text) {
  char* end = nullptr;
  std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0';
}

/// A bar in a name would end the cell.
std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '|' ? std::string("\\|") : std::string(1, c);
  return result;
}

}  // namespace

void Table::add(std::vector<std::string> row) {
  for (std::string& cell : row) cell = printable(cell);
  rows_.push_back(std::move(row));
}

std::vector<std::size_t> Table::widths() const {
  std::vector<std::size_t> result(rows_[0].size(), 0);
  for (const auto& row : rows_)
    for (std::size_t k = 0; k < row.size(); ++k) result[k] = std::max(result[k], width(row[k]));
  return result;
}

std::vector<bool> Table::numeric() const {
  std::vector<bool> result(rows_[0].size(), rows_.size() > 1);
  for (std::size_t r = 1; r < rows_.size(); ++r)
    for (std::size_t k = 0; k < rows_[r].size(); ++k)
      result[k] = result[k] && (rows_[r][k].empty() || is_number(rows_[r][k]));
  return result;
}

std::string Table::text() const {
  const auto wide = widths();
  const auto right = numeric();
  std::string result;
  for (const auto& row : rows_) {
    std::string line;
    for (std::size_t k = 0; k < row.size(); ++k)
      line += (k > 0 ? "  " : "") + padded(row[k], wide[k], right[k]);
    line.erase(line.find_last_not_of(' ') + 1);
    result += line + '\n';
  }
  return result;
}

std::string Table::markdown() const {
  Table copy = *this;
  for (auto& row : copy.rows_)
    for (std::string& cell : row) cell = escaped(cell);
  const auto wide = copy.widths();
  const auto right = copy.numeric();
  std::string result;
  for (std::size_t r = 0; r < copy.rows_.size(); ++r) {
    for (std::size_t k = 0; k < wide.size(); ++k)
      result += "| " + padded(copy.rows_[r][k], wide[k], right[k]) + ' ';
    result += "|\n";
    if (r > 0) continue;
    for (std::size_t k = 0; k < wide.size(); ++k) result += right[k] ? "| ---: " : "| --- ";
    result += "|\n";
  }
  return result;
}

}  // namespace mimbre::app
