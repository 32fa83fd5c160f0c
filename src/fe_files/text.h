#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Words and numbers of finite-element text files.
namespace mimbre::fe {

std::string_view trimmed(std::string_view text);
std::string lower(std::string_view text);
/// At most 40 characters, what cannot be printed as '?', for messages.
std::string shown(std::string_view text);

/// Cuts the next word, which ends at white space, from `rest`; empty when there is none.
std::string_view next_word(std::string_view& rest);
/// Cuts the next field, which ends at `separator`, from `rest`, without the blanks around it.
std::string_view next_field(std::string_view& rest, char separator = ',');

/// A whole number and nothing else.
std::optional<std::int64_t> to_integer(std::string_view text);
/// A finite number and nothing else. Exponents may be written with E, D or, as in Nastran, with nothing but
/// their sign: 1.5-3.
std::optional<double> to_real(std::string_view text);

/// Files that include each other.
constexpr std::size_t kDeepestIncludes = 20;
bool same_file(const std::string& a, const std::string& b);

}  // namespace mimbre::fe
