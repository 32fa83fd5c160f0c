#include "tyre_files/property_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "fe_files/text.h"

namespace mimbre::tyre_files {
namespace {

using fe::shown;
using fe::trimmed;

/// Real files have some 300; a file of other kind may have any number.
constexpr std::size_t most_properties = 10000;

/// With which some editors begin files in UTF-8.
constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

std::string upper(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return result;
}

std::string_view without_comment(std::string_view text) {
  return trimmed(text.substr(0, text.find_first_of("$!")));
}

bool is_row_of_numbers(std::string_view text) {
  while (!trimmed(text).empty())
    if (!fe::to_real(fe::next_word(text))) return false;
  return true;
}

bool is_key(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == ' ' || c == '-' || c == '.' ||
           c == '(' || c == ')';
  });
}

/// The value behind the equals sign: in quotes, which may hold what else begins a comment, or up to a
/// comment.
void take_value(const fe::TextFile& file, std::string_view text, Property& property) {
  text = trimmed(text);
  if (!text.empty() && (text.front() == '\'' || text.front() == '"')) {
    const std::size_t end = text.find(text.front(), 1);
    if (end == std::string_view::npos)
      file.fail(fmt::format("the text of {} has no closing {}", property.key, text.front()));
    property.text = true;
    property.value = trimmed(text.substr(1, end - 1));
    return;
  }
  property.value = without_comment(text);
}

}  // namespace

std::vector<Property> read_properties(fe::TextFile& file) {
  std::vector<Property> properties;
  std::string section;
  bool table = false;  // below the braces that name its columns
  std::string_view line;
  for (bool first = true; file.next(line); first = false) {
    if (first && line.starts_with(byte_order_mark)) line.remove_prefix(byte_order_mark.size());
    line = trimmed(line);
    const std::string_view bare = without_comment(line);
    if (bare.empty()) continue;
    if (bare.front() == '{') {
      table = true;
      continue;
    }
    if (bare.front() == '[') {
      if (bare.back() != ']') file.fail(fmt::format("the section '{}' has no closing bracket", shown(bare)));
      section = upper(trimmed(bare.substr(1, bare.size() - 2)));
      table = false;
      continue;
    }
    const std::size_t equals = line.find('=');
    if (equals >= line.find_first_of("$!") || equals == std::string_view::npos) {
      const bool row = is_row_of_numbers(bare);
      if (row && table) continue;
      file.fail(row ? fmt::format("'{}' stands alone: a value belongs behind its KEY =, a table below {{the "
                                  "names of its columns}}",
                                  shown(bare))
                    : fmt::format("'{}' is no [SECTION], no KEY = VALUE and no row of a table", shown(bare)));
    }
    Property property;
    property.key = upper(trimmed(line.substr(0, equals)));
    if (!is_key(property.key)) file.fail(fmt::format("'{}' cannot be a key", shown(property.key)));
    if (section.empty())
      file.fail(fmt::format("{} stands in front of the first [SECTION]", shown(property.key)));
    property.section = section;
    property.mark = file.mark();
    take_value(file, line.substr(equals + 1), property);
    if (properties.size() == most_properties)
      file.fail(fmt::format("has more than {} properties: not a tyre property file", most_properties));
    properties.push_back(std::move(property));
  }
  return properties;
}

}  // namespace mimbre::tyre_files
