#include "fe_files/nastran/nastran_cards.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>

#include "fe_files/text.h"

// Format: MSC Nastran Quick Reference Guide, "Bulk Data entry: format".

namespace mimbre::fe {

namespace {

constexpr std::size_t kName = 8, kSmall = 8, kLarge = 16;
/// Cards go on for long (RBE3 of a surface), but not without end.
constexpr std::int64_t kLargest = std::int64_t{1} << 60, kMostCopies = 100'000;
constexpr std::size_t kMostCopied = 64;
constexpr std::size_t kMostFields = 50'000'000;

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
  // Of ten fields the last is a mark of continuation; where there are more, all are data.
  const auto data = static_cast<std::size_t>(std::count(line.begin(), line.end(), ','));
  const std::size_t all = data > count ? (data + count) / count * count : count;
  for (std::size_t i = 0; i < all; ++i) fields.emplace_back(next_field(line));
}

bool is_free(std::string_view line) { return line.substr(0, 10).find(',') != std::string_view::npos; }

bool is_continuation(std::string_view line) {
  if (line.empty()) return false;
  if (line[0] == '+' || line[0] == '*') return true;
  const std::string_view text = trimmed(line);
  return text.starts_with(',') || (part(line, 0, kName).empty() && !text.empty());
}

/// A name of a continuation behind its + or *; marks alone and other text (comments in the last field) are
/// none.
std::string continuation_name(std::string_view field) {
  if (!field.starts_with('+') && !field.starts_with('*')) return {};
  return capitals(trimmed(field.substr(1)));
}

/// The last field of a line, that names the line that goes on.
std::string name_ahead(std::string_view line, bool large) {
  if (!is_free(line)) return continuation_name(part(line, kName + 8 * kSmall, kSmall));
  for (int i = 0; i < (large ? 5 : 9); ++i) next_field(line);
  return continuation_name(trimmed(line.substr(0, line.find(','))));
}

std::string name_behind(std::string_view line) {
  return continuation_name(is_free(line) ? next_field(line) : part(line, 0, kName));
}

}  // namespace

std::string capitals(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return result;
}

std::int64_t NastranCard::whole(std::size_t i, const char* what) const {
  if (blank(i)) fail(fmt::format("{} is missing", what));
  return whole(i, what, 0);
}

std::int64_t NastranCard::whole(std::size_t i, const char* what, std::int64_t missing) const {
  if (blank(i)) return missing;
  const auto value = to_integer(field(i));
  if (!value) fail(fmt::format("'{}' is no {}", shown(field(i)), what));
  return *value;
}

std::int64_t NastranCard::label(std::size_t i, const char* what) const {
  const std::int64_t value = whole(i, what);
  if (value <= 0) fail(fmt::format("{} is no {}: it must be from 1", value, what));
  return value;
}

double NastranCard::real(std::size_t i, const char* what, double missing) const {
  if (blank(i)) return missing;
  const auto value = to_real(field(i));
  if (!value) fail(fmt::format("'{}' is no {}", shown(field(i)), what));
  return *value;
}

Eigen::Vector3d NastranCard::vector(std::size_t first, const char* what) const {
  return {real(first, what), real(first + 1, what), real(first + 2, what)};
}

unsigned NastranCard::components(std::size_t i) const {
  unsigned bits = 0;
  if (field(i) == "0") return 0;
  for (const char c : field(i)) {
    if (c == ' ') continue;
    if (c < '1' || c > '6') fail(fmt::format("'{}' are no components (digits 1 to 6)", shown(field(i))));
    bits |= 1u << (c - '1');
  }
  return bits;
}

std::string NastranCards::increased(const std::string& value, std::string_view by) const {
  by.remove_prefix(1);
  if (by.starts_with('(') && by.ends_with(')')) by = trimmed(by.substr(1, by.size() - 2));
  if (value.empty()) return std::string(by);  // a blank field counts as zero
  const auto whole = to_integer(value), step = to_integer(by);
  if (whole && step && std::abs(*whole) < kLargest && std::abs(*step) < kLargest)
    return std::to_string(*whole + *step);
  const auto real = to_real(value), more = to_real(by);
  if (!real || !more)
    throw InputError(lines_.mark(),
                     fmt::format("'{}' is not added to '{}' by replication", shown(by), shown(value)));
  return fmt::format("{:#}", *real + *more);
}

void NastranCards::replicate(NastranCard& card) {
  card.name = previous_.name;
  card.fields.clear();
  for (std::size_t i = 0; i < pattern_.size(); ++i) {
    const std::string& field = pattern_[i];
    if (field == "==") {
      card.fields.insert(
          card.fields.end(),
          previous_.fields.begin() + static_cast<std::ptrdiff_t>(std::min(i, previous_.fields.size())),
          previous_.fields.end());
      break;
    }
    if (field == "=")
      card.fields.emplace_back(previous_.field(i));
    else if (field.starts_with('*'))
      card.fields.push_back(increased(std::string(previous_.field(i)), field));
    else
      card.fields.push_back(field);
  }
  previous_ = card;
}

bool NastranCards::next(NastranCard& card) {
  if (repeat_ > 0) {
    --repeat_;
    card.mark = previous_.mark;
    replicate(card);
    return true;
  }
  std::string_view raw;
  while (lines_.next(raw)) {
    const std::string line = expanded(raw);
    if (trimmed(line).empty() || is_continuation(line)) continue;
    card.fields.clear();
    card.mark = lines_.mark();
    const bool free = is_free(line);
    std::string_view rest = line;
    std::string_view first = free ? next_field(rest) : part(line, 0, kName);
    if (first.starts_with('=') && !previous_.name.empty()) {
      if (first == "=") {
        pattern_.clear();
        add_fields(line, free, false, pattern_);
        replicate(card);
        return true;
      }
      first.remove_prefix(1);
      first = trimmed(first);
      if (first.starts_with('(') && first.ends_with(')')) first = trimmed(first.substr(1, first.size() - 2));
      const auto count = to_integer(first);
      if (!count || *count < 1 || *count > kMostCopies || pattern_.empty())
        throw InputError(card.mark, fmt::format("'{}' is no count of copies, such as =(3)", shown(line)));
      repeat_ = *count;
      return next(card);
    }
    const bool large = first.ends_with('*');
    if (large) first.remove_suffix(1);
    card.name = capitals(trimmed(first));
    if (card.name.starts_with("ENDDATA")) return false;
    add_fields(line, free, large, card.fields);
    std::string ahead = name_ahead(line, large);
    while (lines_.next(raw)) {
      const std::string more = expanded(raw);
      if (trimmed(more).empty()) continue;
      if (!is_continuation(more)) {
        lines_.put_back();
        break;
      }
      const bool more_free = is_free(more);
      // In free field the mark alone does not determine the width: it goes on as the card began.
      const bool more_large = more[0] == '*' || (more_free && large);
      if (const std::string behind = name_behind(more); !ahead.empty() && !behind.empty() && ahead != behind)
        throw InputError(
            lines_.mark(),
            fmt::format("goes on with '{}' where the line before names '{}': lines of a card must "
                        "follow one another",
                        shown(behind), shown(ahead)));
      ahead = name_ahead(more, more_large);
      add_fields(more, more_free, more_large, card.fields);
      if (card.fields.size() > kMostFields) card.fail("the card has more fields than any model needs");
    }
    // Only short cards are copied by replication.
    if (card.fields.size() <= kMostCopied) previous_ = card;
    return true;
  }
  return false;
}

}  // namespace mimbre::fe
