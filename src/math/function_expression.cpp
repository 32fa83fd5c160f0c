#include "math/function_expression.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <muParser.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <thread>
#include <utility>

#include "mimbre/diagnostics.h"

namespace mimbre {

namespace {

constexpr std::size_t longest_text = 10000;
constexpr int deepest_nesting = 100;

/// For messages: the beginning of the text, on one line.
std::string shortened(std::string text) {
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20; }, ' ');
  return text;
}

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
  throw InputError(Mark{}, fmt::format("expression '{}': {}", shortened(text), why));
}

/// What the parser would take, but a formula has no use for: assignments change variables, text has no value.
/// Deep nesting and great length are limited so that hostile input stays cheap.
void check_text(const std::string& text) {
  if (text.size() > longest_text)
    refuse(text, fmt::format("has {} characters, at most {} are allowed", text.size(), longest_text));
  int depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool printable = static_cast<unsigned char>(c) >= 0x20 && static_cast<unsigned char>(c) < 0x7f;
    if (!printable && c != '\t' && c != '\n' && c != '\r')
      refuse(text, fmt::format("unexpected character at position {}", i + 1));
    if (c == '"' || c == '\'') refuse(text, "quotes are not allowed");
    if (c == '(' || c == '?') ++depth;
    if (c == ')') --depth;
    if (depth > deepest_nesting)
      refuse(text, fmt::format("is nested deeper than {} levels", deepest_nesting));
    if (c != '=') continue;
    const bool second_half =
        i > 0 && (text[i - 1] == '=' || text[i - 1] == '<' || text[i - 1] == '>' || text[i - 1] == '!');
    const bool first_half = i + 1 < text.size() && text[i + 1] == '=';
    if (!second_half && !first_half) refuse(text, "'=' assigns; to compare, write '=='");
  }
}

/// What the conditions of the expression that this thread evaluates write to, or are overruled by.
thread_local Choices* noted = nullptr;
thread_local const Choices* held = nullptr;

constexpr const char* choice_function = "choice__";

double choose(double number, double condition) {
  const auto k = static_cast<std::size_t>(number);
  if (held && held->taken[k] != 0) return held->taken[k] - 1;
  if (noted) noted->taken[k] = condition != 0 ? 2 : 1;
  return condition;
}

/// The text with each condition of `?:` as the argument of the function above: "(t<1 ? a : b)" becomes
/// "(choice__(0,(t<1 ))? a : b)". A condition reaches back to what it is enclosed by, or to the choice
/// before.
std::string with_numbered_choices(const std::string& text) {
  std::vector<std::pair<std::size_t, std::string>> insertions;
  std::vector<std::size_t> starts{0};
  std::size_t count = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '?' && count < Choices::most) {
      insertions.emplace_back(starts.back(), fmt::format("{}({},(", choice_function, count++));
      insertions.emplace_back(i, "))");
    }
    if (c == '(') starts.push_back(i + 1);
    if (c == ')' && starts.size() > 1) starts.pop_back();
    if (c == '?' || c == ':' || c == ',') starts.back() = i + 1;
  }
  std::sort(insertions.begin(), insertions.end());
  std::string result;
  std::size_t at = 0;
  for (const auto& [place, inserted] : insertions) {
    result += text.substr(at, place - at) + inserted;
    at = place;
  }
  return result + text.substr(at);
}

std::string message_of(const mu::Parser::exception_type& error, const mu::Parser& parser,
                       const std::vector<std::string>& variables) {
  const std::string token = error.GetToken();
  const bool name = !token.empty() && (std::isalpha(static_cast<unsigned char>(token[0])) || token[0] == '_');
  if (error.GetCode() == mu::ecUNASSIGNABLE_TOKEN && name) {
    // The token runs to the end of the text; its name is what an unknown name is.
    const std::string unknown = token.substr(
        0,
        static_cast<std::size_t>(std::find_if(token.begin(), token.end(),
                                              [](unsigned char c) { return !std::isalnum(c) && c != '_'; }) -
                                 token.begin()));
    std::vector<std::string> known = variables;
    known.push_back("pi");
    for (const auto& function : parser.GetFunDef()) known.push_back(function.first);
    return fmt::format("unknown name '{}'{}; the variables here are: {}", unknown,
                       did_you_mean(unknown, known), fmt::join(variables, ", "));
  }
  std::string message = error.GetMsg();
  while (!message.empty() && (message.back() == '.' || message.back() == ' ')) message.pop_back();
  return message;
}

}  // namespace

struct Expression::Compiled {
  mu::Parser parser;
  std::array<double, most_variables> variables{};  ///< the parser reads them here
  std::size_t count = 0;
  bool has_choices = false;
  std::atomic_flag busy;
};

Expression::Expression(const std::string& text, std::vector<std::string> variables)
    : compiled_(std::make_unique<Compiled>()) {
  if (variables.empty() || variables.size() > most_variables)
    throw std::invalid_argument(fmt::format("an expression has 1 to 3 variables, not {}", variables.size()));
  check_text(text);
  if (std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isspace(c); }))
    refuse(text, "is empty");
  mu::Parser& parser = compiled_->parser;
  compiled_->count = variables.size();
  try {
    for (std::size_t i = 0; i < variables.size(); ++i)
      parser.DefineVar(variables[i], &compiled_->variables[i]);
    parser.DefineConst("pi", std::numbers::pi);
    parser.SetExpr(text);
    parser.Eval();  // compiles; later evaluations run the compiled form
    if (parser.GetNumResults() != 1) refuse(text, "has several values, separated by commas");
    compiled_->has_choices = text.find('?') != std::string::npos;
    if (compiled_->has_choices) {
      parser.DefineFun(choice_function, choose, false);
      parser.SetExpr(with_numbered_choices(text));
      parser.Eval();
    }
  } catch (const mu::Parser::exception_type& error) {
    refuse(text, message_of(error, parser, variables));
  }
}

Expression::~Expression() = default;

bool Expression::has_choices() const { return compiled_->has_choices; }

Choices Expression::choices(std::span<const double, most_variables> values) const {
  Choices result;
  noted = &result;
  evaluate(values);
  noted = nullptr;
  return result;
}

double Expression::value(std::span<const double, most_variables> values, const Choices& choices) const {
  held = &choices;
  const double result = evaluate(values);
  held = nullptr;
  return result;
}

double Expression::value(std::span<const double, most_variables> values) const { return evaluate(values); }

double Expression::evaluate(std::span<const double, most_variables> values) const {
  while (compiled_->busy.test_and_set(std::memory_order_acquire)) std::this_thread::yield();
  std::copy_n(values.begin(), compiled_->count, compiled_->variables.begin());
  double result = std::numeric_limits<double>::quiet_NaN();
  try {
    result = compiled_->parser.Eval();
  } catch (...) {
    // Not a number, then: a step cannot throw, and what uses the value will tell that it is not finite.
  }
  compiled_->busy.clear(std::memory_order_release);
  return result;
}

}  // namespace mimbre
