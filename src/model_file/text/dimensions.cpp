#include "model_file/text/dimensions.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
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

/// Functions whose value is in the unit of their arguments, and those of an argument in any unit; all others
/// take numbers or angles.
constexpr std::array<std::string_view, 5> keeping{"abs", "min", "max", "sum", "avg"};
constexpr std::array<std::string_view, 3> of_any{"sqrt", "sign", "atan2"};

template <std::size_t n>
bool among(const std::array<std::string_view, n>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Whether the dimension is that of a number, or of an angle.
bool is_number(Dimension d) {
  d.radian = 0;
  return d == Dimension{};
}

/// Walks an expression by the usual rules of precedence. What it does not understand is left to who
/// evaluates.
class DimensionWalk {
 public:
  DimensionWalk(const std::string& text, const Scope& scope, const std::vector<Variable>& variables)
      : text_(text), scope_(scope), variables_(variables) {}

  Measure whole() { return choice(); }
  bool any_unit() const { return units_ > 0; }

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

  std::string text_from(std::size_t start) const {
    const std::string part = text_.substr(start, at_ - start);
    const std::size_t first = part.find_first_not_of(" \t\n"), last = part.find_last_not_of(" \t\n");
    return first == std::string::npos ? part : part.substr(first, last + 1 - first);
  }

  /// Throws where a part with units in it, which begins at `start` and ends here, should have none.
  void require_number(const Measure& part, std::size_t start, int units_before, const std::string& what,
                      const std::string& needs) const {
    if (part.kind != Measure::known || units_ == units_before || is_number(part.dimension)) return;
    throw ExpressionError(fmt::format("'{}': {} '{}' is in {}; {}", text_, what, text_from(start),
                                      to_text(part.dimension), needs));
  }

  Measure choice() {
    const std::size_t start = at_;
    const int before = units_;
    const Measure condition = logical();
    if (next() != '?') return condition;
    require_number(condition, start, before, "the condition", needed_condition);
    take('?');
    const Measure yes = choice();
    take(':');
    return joined(yes, choice(), "the two branches of one choice");
  }

  /// Comparisons, joined by && and ||.
  Measure logical() {
    std::size_t start = at_;
    int before = units_;
    Measure left = comparison();
    while (next() == '&' || next() == '|') {
      require_number(left, start, before, "the condition", needed_condition);
      while (next() == '&' || next() == '|') ++at_;
      start = at_;
      before = units_;
      require_number(comparison(), start, before, "the condition", needed_condition);
      left = {};
    }
    return left;
  }

  Measure comparison() {
    Measure left = sum();
    while (next() != '\0' && std::string_view("<>=!").find(next()) != std::string_view::npos) {
      while (next() != '\0' && std::string_view("<>=!").find(next()) != std::string_view::npos) ++at_;
      joined(left, sum(), "compared");
      left = {};
    }
    return left;
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
    const int before = units_;
    const Measure exponent = factor();
    require_number(exponent, start, before, "the exponent",
                   "an exponent is a number; a unit behind it belongs to it, so write (2^3)*1 mm for 8 mm");
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
    ++units_;
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
    const bool keeps = among(keeping, function);
    const int units_before = units_;
    Measure all;
    bool first = true;
    do {
      const std::size_t start = at_;
      const int before = units_;
      const Measure one = choice();
      if (!keeps && !among(of_any, function))
        require_number(one, start, before, fmt::format("the argument of {}", function),
                       "a number or an angle is needed there");
      const bool joins = keeps || (function == "atan2" && units_ > units_before);
      all = first || !joins ? one : joined(all, one, fmt::format("arguments of one {}", function).c_str());
      first = false;
    } while (take(','));
    take(')');
    if (keeps) return all;
    return function == "sqrt" ? root(all) : Measure{};
  }

  /// The square root; what has no whole exponents is left to who evaluates.
  static Measure root(const Measure& of) {
    if (of.kind != Measure::known) return of;
    Dimension d = of.dimension;
    for (int* const exponent : {&d.kilogram, &d.metre, &d.second, &d.radian, &d.ampere}) {
      if (*exponent % 2 != 0) return unknown;
      *exponent /= 2;
    }
    return {Measure::known, d};
  }

  static constexpr const char* needed_condition = "a condition compares, for example x > 2 mm";

  const std::string& text_;
  const Scope& scope_;
  const std::vector<Variable>& variables_;
  std::size_t at_ = 0;
  int units_ = 0;  ///< that have been read
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
