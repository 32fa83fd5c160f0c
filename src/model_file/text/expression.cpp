#include "model_file/text/expression.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "math/function_expression.h"
#include "mimbre/diagnostics.h"
#include "model_file/text/dimensions.h"
#include "model_file/text/scanning.h"

namespace mimbre::model_file {
namespace {

constexpr std::array functions{"sin",  "cos",   "tan",   "asin",  "acos", "atan",  "atan2", "sinh", "cosh",
                               "tanh", "asinh", "acosh", "atanh", "log2", "log10", "log",   "ln",   "exp",
                               "sqrt", "sign",  "rint",  "abs",   "min",  "max",   "sum",   "avg"};

/// Bounds the work on hostile texts.
constexpr std::size_t longest = 2000;
constexpr int deepest = 100;

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\n");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\n") - first + 1);
}

/// "l (or x), v, t"
std::string listed(const std::vector<Variable>& variables) {
  std::string text;
  for (const Variable& v : variables) {
    text += (text.empty() ? "" : ", ") + v.names.front();
    // Behind a signal's name stands what it is replaced by.
    if (v.names.size() > 1 && !v.names[1].ends_with('_')) text += fmt::format(" (or {})", v.names[1]);
  }
  return text;
}

std::string value_of_name(const std::string& name, const Scope& scope,
                          const std::vector<Variable>& variables) {
  if (scope.is_tunable(name))
    throw ExpressionError(
        fmt::format("parameter '{}' is tunable, and a value here cannot change during a run; expressions of "
                    "laws, loads, actuators and signals can use it, for example elastic: \"{}*x\"",
                    name, name));
  if (const ParameterValue* value = scope.find(name)) {
    if (const double* number = std::get_if<double>(value)) return fmt::format("({:.17g})", *number);
    const auto& text = std::get<std::string>(*value);
    const int* word = scope.find_word(text);
    if (!word)
      throw ExpressionError(fmt::format("parameter '{}' is the name '{}', and no number", name, text));
    return fmt::format("({})", *word);
  }
  if (name == "true") return "1";
  if (name == "false") return "0";
  if (const int* word = scope.find_word(name)) return fmt::format("({})", *word);
  if (is_variable_name(name))
    throw ExpressionError(
        variables.empty()
            ? fmt::format("'{}' is a variable of laws; there is none here", name)
            : fmt::format(
                  "'{0}' is no variable of this law; it depends on {1}, and an output or signal that is "
                  "called '{0}' needs another name to be used in it",
                  name, listed(variables)));
  auto known = scope.names();
  known.insert(known.end(), functions.begin(), functions.end());
  const std::string hint = did_you_mean(name, known);
  if (name == "nan" || name == "inf" || name == "infinity") throw ExpressionError("is not a finite number");
  throw ExpressionError(fmt::format("'{}' is not a parameter or function{}", name, hint));
}

/// A number, perhaps with a unit behind it, and nothing to reckon.
bool is_one_number(const std::string& text) {
  const std::size_t start = text.find_first_not_of(" -+");
  if (start == std::string::npos || !(is_digit(text[start]) || text[start] == '.')) return false;
  const std::string behind = text.substr(number_end(text, start));
  return behind.find_first_of("+-()<>=?,&|") == std::string::npos && behind.find(" *") == std::string::npos &&
         behind.find(" /") == std::string::npos && !behind.starts_with('*') && !behind.starts_with('/');
}

/// Where a text processor has replaced what is on the keyboard.
std::string typographic_hint(const std::string& text) {
  const auto has = [&](std::initializer_list<const char*> signs) {
    return std::any_of(signs.begin(), signs.end(),
                       [&](const char* sign) { return text.find(sign) != std::string::npos; });
  };
  if (has({"“", "”", "„", "‘", "’"})) return "; quotes are \" or '";
  if (has({"−", "–", "—"})) return "; write a minus as '-'";
  if (has({"×", "·", "∙"})) return "; write a product with '*'";
  return {};
}

/// The parser's words without places, which count in a text that has the parameters' values in it.
std::string without_positions(std::string message) {
  constexpr std::string_view mark = " at position ";
  for (auto at = message.find(mark); at != std::string::npos; at = message.find(mark)) {
    const auto end = message.find_first_not_of("0123456789", at + mark.size());
    message.erase(at, end == std::string::npos ? end : end - at);
  }
  return message;
}

}  // namespace

const ParameterValue* Scope::find(const std::string& name) const {
  for (const Scope* scope = this; scope; scope = scope->outer)
    if (const auto it = scope->values.find(name); it != scope->values.end()) return &it->second;
  return nullptr;
}

bool Scope::is_tunable(const std::string& name) const {
  for (const Scope* scope = this; scope; scope = scope->outer)
    if (scope->values.contains(name)) return scope->tunables.contains(name);
  return false;
}

const int* Scope::find_word(const std::string& word) const {
  for (const Scope* scope = this; scope; scope = scope->outer)
    if (const auto it = scope->words.find(word); it != scope->words.end()) return &it->second;
  return nullptr;
}

const std::string* Scope::chooser_of(const std::string& word) const {
  for (const Scope* scope = this; scope; scope = scope->outer)
    if (const auto it = scope->chosen_by.find(word); it != scope->chosen_by.end()) return &it->second;
  return nullptr;
}

std::vector<std::string> Scope::names() const {
  std::vector<std::string> result;
  for (const Scope* scope = this; scope; scope = scope->outer)
    for (const auto& [name, value] : scope->values) result.push_back(name);
  return result;
}

std::vector<Variable> variables_of(LawOf law, const Quantity& x) {
  switch (law) {
    case LawOf::coordinate:
      return {{"x", {"l", "x"}, x}};
    case LawOf::rate:
      return {{"x", {"v", "x"}, x}};
    case LawOf::time:
      return {{"t", {"t"}, quantity::time}};
    case LawOf::all:
      break;
  }
  return {{"l", {"l", "x"}, quantity::length}, {"v", {"v"}, quantity::speed}, {"t", {"t"}, quantity::time}};
}

bool is_variable_name(const std::string& name) { return find_variable(name, variables_of(LawOf::all)); }

bool is_function_name(const std::string& name) {
  return std::find(functions.begin(), functions.end(), name) != functions.end();
}

std::string substitute_parameters(const std::string& text, const Scope& scope,
                                  const std::vector<Variable>& variables, const Quantity& wanted) {
  if (text.size() > longest) throw ExpressionError(fmt::format("is longer than {} characters", longest));
  const bool alone = is_one_number(text);
  std::string result;
  int depth = 0;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '(' || c == '?') ++depth;
    if (c == ')') --depth;
    if (depth > deepest) throw ExpressionError(fmt::format("is nested deeper than {} levels", deepest));
    if (starts_name(c)) {
      const std::size_t end = name_end(text, i);
      const std::string name = text.substr(i, end - i);
      const std::size_t next = text.find_first_not_of(" \t\n", end);
      const bool called = next != std::string::npos && text[next] == '(';
      if (called && !is_function_name(name))
        throw ExpressionError(fmt::format("there is no function '{}'{}", name,
                                          did_you_mean(name, {functions.begin(), functions.end()})));
      const Variable* const as = called ? nullptr : find_variable(name, variables);
      if (as)
        result += as->name;
      else if (called || name == "pi")
        result += name;
      else
        result += value_of_name(name, scope, variables);
      i = end;
    } else if (is_digit(c) || c == '.') {
      const std::size_t end = number_end(text, i);
      const auto unit = unit_behind(text, end, scope, variables, alone ? wanted : quantity::any);
      const std::string digits = text.substr(i, end - i);
      result +=
          unit ? fmt::format("({}*{:.17g}/{:.17g})", digits, unit->numerator, unit->denominator) : digits;
      i = unit ? unit->end : end;
    } else if (c == '=') {
      // A lone '=' may be meant for '=='.
      const bool compares = (i > 0 && std::string("<>!=").find(text[i - 1]) != std::string::npos) ||
                            (i + 1 < text.size() && text[i + 1] == '=');
      if (!compares) throw ExpressionError("'=' is no operator; compare with '=='");
      result += c;
      ++i;
    } else if (text.compare(i, 2, "**") == 0) {
      throw ExpressionError(fmt::format("'{}': '**' is no operator; a power is written with '^'", text));
    } else if (std::string(" \t\n+-*/^()<>!&|?:,").find(c) != std::string::npos) {
      result += c;
      ++i;
    } else {
      throw ExpressionError(fmt::format("'{}' is no number or expression{}", text, typographic_hint(text)));
    }
  }
  check_dimensions(text, scope, variables, wanted);
  return result;
}

double evaluate(const std::string& given, const Scope& scope, const Quantity& wanted) {
  const std::string text = !given.empty() && given[0] == '$' ? given.substr(1) : given;
  double value = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status == std::errc() && end == text.data() + text.size()) {
    if (!std::isfinite(value)) throw ExpressionError(fmt::format("'{}' is not a finite number", given));
    return value;
  }
  if (text == ".inf" || text == "-.inf" || text == "+.inf" || text == ".nan" || text == ".NaN" ||
      text == ".Inf")
    throw ExpressionError(fmt::format("'{}' is not a finite number", given));
  const std::string expression = substitute_parameters(text, scope, {}, wanted);
  if (trimmed(expression).empty()) throw ExpressionError("is empty; a number is needed");
  try {
    value = Expression(expression, {}).value(nullptr);
  } catch (const std::invalid_argument& error) {
    const std::string why = error.what();
    if (why.starts_with("has several values"))
      throw ExpressionError(
          fmt::format("'{}' is a list of numbers; one is needed (with a decimal point, no comma)", given));
    throw ExpressionError(fmt::format("'{}' is no expression: {}", given, without_positions(why)));
  }
  if (!std::isfinite(value))
    throw ExpressionError(fmt::format("'{}' is not a finite number ({})", given, value));
  return value;
}

std::string evaluate_word(const std::string& given, const Scope& scope) {
  std::string text = trimmed(given);
  if (text.size() > longest) throw ExpressionError(fmt::format("is longer than {} characters", longest));
  for (auto question = text.find('?'); question != std::string::npos; question = text.find('?')) {
    const auto colon = text.find(':', question);
    if (colon == std::string::npos)
      throw ExpressionError(fmt::format("'{}': a choice is written 'condition ? word : word'", given));
    const bool holds = evaluate(text.substr(0, question), scope) != 0;
    text = trimmed(holds ? text.substr(question + 1, colon - question - 1) : text.substr(colon + 1));
  }
  if (text.size() > 1 && text[0] == '$') {
    const std::string name = text.substr(1);
    const ParameterValue* value = scope.find(name);
    if (!value)
      throw ExpressionError(
          fmt::format("there is no parameter '{}'{}", name, did_you_mean(name, scope.names())));
    return to_text(*value);
  }
  return text;
}

std::string to_text(const ParameterValue& value) {
  if (const double* number = std::get_if<double>(&value)) return fmt::format("{}", *number);
  return std::get<std::string>(value);
}

}  // namespace mimbre::model_file
