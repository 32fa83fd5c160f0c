#include "model_file/text/dimensions.h"

#include <fmt/format.h>

#include <cctype>
#include <cstdlib>
#include <string_view>

#include "model_file/text/scanning.h"

namespace mimbre::model_file {
namespace {

/// What a part of an expression measures.
struct Measure {
  enum Kind { factor, unknown, known } kind = factor;
  Dimension dimension = {};  ///< known
};
constexpr Measure unknown{Measure::unknown, {}};

/// Walks an expression by the usual rules of precedence. What it does not understand is left to who
/// evaluates.
class DimensionWalk {
 public:
  DimensionWalk(const std::string& text, const Scope& scope, const std::vector<Variable>& variables)
      : text_(text), scope_(scope), variables_(variables) {}

  Measure whole() { return choice(); }
  bool any_unit() const { return any_unit_; }

 private:
  char next() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  bool take(char c) {
    if (next() != c) return false;
    ++at_;
    return true;
  }

  Measure joined(const Measure& a, const Measure& b, const char* how) const {
    if (a.kind == Measure::known && b.kind == Measure::known && !fits(a.dimension, Quantity{"", b.dimension}))
      throw ExpressionError(fmt::format("'{}': {} and {} cannot be {}", text_, to_text(a.dimension),
                                        to_text(b.dimension), how));
    return a.kind > b.kind ? a : b;
  }

  Measure choice() {
    const Measure condition = logical();
    if (!take('?')) return condition;
    const Measure yes = choice();
    take(':');
    return joined(yes, choice(), "the two branches of one choice");
  }

  Measure logical() {
    Measure left = sum();
    for (;;) {
      std::string comparing;
      while (next() != '\0' && std::string_view("<>=!&|").find(next()) != std::string_view::npos)
        comparing += text_[at_++];
      if (comparing.empty()) return left;
      const Measure right = sum();
      if (comparing != "&&" && comparing != "||") joined(left, right, "compared");
      left = {};
    }
  }

  Measure sum() {
    Measure result = term();
    while (next() == '+' || next() == '-') {
      ++at_;
      result = joined(result, term(), "added");
    }
    return result;
  }

  Measure term() {
    Measure result = factor();
    while (next() == '*' || next() == '/') {
      const int sign = text_[at_++] == '*' ? 1 : -1;
      const Measure other = factor();
      if (result.kind == Measure::unknown || other.kind == Measure::unknown)
        result = unknown;
      else if (other.kind == Measure::known)
        result = {Measure::known, product(result.dimension, power(other.dimension, sign))};
    }
    return result;
  }

  Measure factor() {
    while (take('-') || take('+')) {
    }
    const Measure base = primary();
    if (!take('^')) return base;
    next();
    const std::size_t start = at_;
    const Measure exponent = factor();
    if (base.kind != Measure::known) return base;
    const std::string written = text_.substr(start, at_ - start);
    char* end = nullptr;
    const long whole = std::strtol(written.c_str(), &end, 10);
    if (exponent.kind != Measure::factor || *end != '\0' || std::abs(whole) > 9) return unknown;
    return {Measure::known, power(base.dimension, static_cast<int>(whole))};
  }

  Measure primary() {
    const char c = next();
    if (c == '(') {
      ++at_;
      const Measure inside = choice();
      take(')');
      return inside;
    }
    if (is_digit(c) || c == '.') return number();
    if (starts_name(c)) return name();
    if (c != '\0') ++at_;
    return unknown;
  }

  Measure number() {
    at_ = number_end(text_, at_);
    const auto unit = unit_behind(text_, at_, scope_, variables_, quantity::any);
    if (!unit) return {};
    any_unit_ = true;
    at_ = unit->end;
    return {Measure::known, unit->dimension};
  }

  Measure name() {
    const std::size_t start = at_;
    at_ = name_end(text_, at_);
    const std::string name = text_.substr(start, at_ - start);
    if (take('(')) return call(name);
    if (const Variable* variable = find_variable(name, variables_))
      return variable->quantity.dimension ? Measure{Measure::known, *variable->quantity.dimension} : unknown;
    return name == "pi" ? Measure{} : unknown;
  }

  Measure call(const std::string& function) {
    Measure all = choice();
    const bool keeps =
        function == "abs" || function == "min" || function == "max" || function == "sum" || function == "avg";
    while (take(',')) {
      const Measure one = choice();
      if (keeps) all = joined(all, one, "arguments of one function");
    }
    take(')');
    if (keeps) return all;
    return function == "sqrt" && all.kind != Measure::factor ? unknown : Measure{};
  }

  const std::string& text_;
  const Scope& scope_;
  const std::vector<Variable>& variables_;
  std::size_t at_ = 0;
  bool any_unit_ = false;
};

}  // namespace

void check_dimensions(const std::string& text, const Scope& scope, const std::vector<Variable>& variables,
                      const Quantity& wanted) {
  DimensionWalk walk(text, scope, variables);
  Measure measure;
  try {
    measure = walk.whole();
  } catch (const ExpressionError&) {
    if (walk.any_unit()) throw;
  }
  if (!walk.any_unit() || measure.kind != Measure::known || fits(measure.dimension, wanted)) return;
  const std::string found = to_text(measure.dimension);
  throw ExpressionError(fmt::format("'{}' is in {}; {}", text, found, needed(wanted)));
}

}  // namespace mimbre::model_file
