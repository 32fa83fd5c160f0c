#include "fe_files/nastran_cards.h"

#include <algorithm>
#include <cctype>

#include "fe_files/text.h"

// Format: MSC Nastran Quick Reference Guide, "Bulk Data entry: format".

namespace mimbre::fe {

namespace {

constexpr std::size_t kName = 8, kSmall = 8, kLarge = 16;

/// With tabs as blanks up to the next multiple of eight, and without a comment behind.
std::string expanded(std::string_view line) {
  std::string result;
  for (const char c : line.substr(0, line.find('$'))) {
    if (c != '\t') {
      result += c;
      continue;
    }
    do result += ' ';
    while (result.size() % kName != 0);
  }
  return result;
}

std::string_view part(std::string_view line, std::size_t from, std::size_t size) {
  return from < line.size() ? trimmed(line.substr(from, size)) : std::string_view();
}

/// Appends the fields of one line, without its first (name or continuation mark) and last.
void add_fields(std::string_view line, bool free, bool large, std::vector<std::string>& fields) {
  const std::size_t count = large ? 4 : 8;
  if (!free) {
    const std::size_t width = large ? kLarge : kSmall;
    for (std::size_t i = 0; i < count; ++i) fields.emplace_back(part(line, kName + i * width, width));
    return;
  }
  next_field(line);
  for (std::size_t i = 0; i < count; ++i) fields.emplace_back(next_field(line));
}

bool is_free(std::string_view line) { return line.substr(0, 10).find(',') != std::string_view::npos; }

bool is_continuation(std::string_view line) {
  if (line.empty()) return false;
  if (line[0] == '+' || line[0] == '*' || line[0] == ',') return true;
  return part(line, 0, kName).empty() && !trimmed(line).empty();
}

}  // namespace

bool NastranCards::next(NastranCard& card) {
  std::string_view raw;
  while (file_.next(raw)) {
    const std::string line = expanded(raw);
    if (trimmed(line).empty() || is_continuation(line)) continue;
    card.fields.clear();
    card.mark = file_.mark();
    const bool free = is_free(line);
    std::string_view rest = line;
    const std::string_view first = free ? next_field(rest) : part(line, 0, kName);
    const bool large = first.ends_with('*');
    card.name = trimmed(large ? first.substr(0, first.size() - 1) : first);
    std::transform(card.name.begin(), card.name.end(), card.name.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    add_fields(line, free, large, card.fields);
    while (file_.next(raw)) {
      const std::string more = expanded(raw);
      if (trimmed(more).empty()) continue;
      if (!is_continuation(more)) {
        file_.put_back();
        break;
      }
      const bool more_free = is_free(more);
      // In free field the mark alone tells nothing of the width: it goes on as the card began.
      const bool more_large = more[0] == '*' || (more_free && large);
      add_fields(more, more_free, more_large, card.fields);
    }
    return true;
  }
  return false;
}

}  // namespace mimbre::fe
