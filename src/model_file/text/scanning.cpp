#include "model_file/text/scanning.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace mimbre::model_file {

bool starts_name(char c) { return std::isalpha(static_cast<unsigned char>(c)) || c == '_'; }
bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)); }

std::size_t name_end(const std::string& text, std::size_t i) {
  while (i < text.size() && (starts_name(text[i]) || is_digit(text[i]))) ++i;
  return i;
}

std::size_t number_end(const std::string& text, std::size_t i) {
  while (i < text.size() && (is_digit(text[i]) || text[i] == '.')) ++i;
  if (i < text.size() && (text[i] == 'e' || text[i] == 'E')) {
    std::size_t j = i + 1;
    if (j < text.size() && (text[j] == '+' || text[j] == '-')) ++j;
    if (j < text.size() && is_digit(text[j])) {
      while (j < text.size() && is_digit(text[j])) ++j;
      i = j;
    }
  }
  return i;
}

const Variable* find_variable(const std::string& name, const std::vector<Variable>& variables) {
  for (const Variable& v : variables)
    if (std::find(v.names.begin(), v.names.end(), name) != v.names.end()) return &v;
  return nullptr;
}

std::optional<WrittenUnit> unit_behind(const std::string& text, std::size_t i, const Scope& scope,
                                       const std::vector<Variable>& variables, const Quantity& wanted) {
  const std::size_t at = text.find_first_not_of(" \t\n", i);
  if (at == std::string::npos || !(starts_name(text[at]) || (text[at] & 0x80))) return {};
  const auto known = [&](const std::string& name) {
    return scope.find(name) || find_variable(name, variables) || name == "pi";
  };
  if (auto unit = read_unit(text, at, known)) return unit;
  const std::string name = text.substr(at, std::max(name_end(text, at), at + 1) - at);
  if (!starts_name(text[at])) return {};
  if (known(name) || is_function_name(name))
    throw ExpressionError(fmt::format("'{}': an operator is missing before '{}'", text, name));
  throw ExpressionError(fmt::format("'{}': '{}' is no unit{}", text, name, unit_hint(name, wanted)));
}

}  // namespace mimbre::model_file
