#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "math/expression_program.h"
#include "mimbre/diagnostics.h"

namespace mimbre {
namespace {

using Op = ExpressionProgram::Op;

constexpr int deepest_nesting = 100;

/// A function of so many arguments; of several it is applied from the left, two at a time.
struct FunctionRow {
  std::string_view name;
  Op op;
  std::size_t arguments;  ///< 0: one or more
};
constexpr std::array functions{FunctionRow{"sin", Op::sin, 1},     FunctionRow{"cos", Op::cos, 1},
                               FunctionRow{"tan", Op::tan, 1},     FunctionRow{"asin", Op::asin, 1},
                               FunctionRow{"acos", Op::acos, 1},   FunctionRow{"atan", Op::atan, 1},
                               FunctionRow{"atan2", Op::atan2, 2}, FunctionRow{"sinh", Op::sinh, 1},
                               FunctionRow{"cosh", Op::cosh, 1},   FunctionRow{"tanh", Op::tanh, 1},
                               FunctionRow{"asinh", Op::asinh, 1}, FunctionRow{"acosh", Op::acosh, 1},
                               FunctionRow{"atanh", Op::atanh, 1}, FunctionRow{"log2", Op::log2, 1},
                               FunctionRow{"log10", Op::log10, 1}, FunctionRow{"log", Op::ln, 1},
                               FunctionRow{"ln", Op::ln, 1},       FunctionRow{"exp", Op::exp, 1},
                               FunctionRow{"sqrt", Op::sqrt, 1},   FunctionRow{"sign", Op::sign, 1},
                               FunctionRow{"rint", Op::rint, 1},   FunctionRow{"abs", Op::abs, 1},
                               FunctionRow{"min", Op::min, 0},     FunctionRow{"max", Op::max, 0},
                               FunctionRow{"sum", Op::add, 0},     FunctionRow{"avg", Op::add, 0}};

struct ConstantRow {
  std::string_view name;
  double value;
};
constexpr std::array constants{ConstantRow{"pi", std::numbers::pi}, ConstantRow{"_pi", std::numbers::pi},
                               ConstantRow{"_e", std::numbers::e}};

struct OperatorRow {
  std::string_view sign;
  Op op;
};
/// From the weakest to the strongest; the longer sign first. Powers and signs are apart.
constexpr std::array<std::array<OperatorRow, 6>, 5> levels{{{{{"||", Op::either}}},
                                                            {{{"&&", Op::both}}},
                                                            {{{"<=", Op::less_or_equal},
                                                              {">=", Op::greater_or_equal},
                                                              {"==", Op::equal},
                                                              {"!=", Op::not_equal},
                                                              {"<", Op::less},
                                                              {">", Op::greater}}},
                                                            {{{"+", Op::add}, {"-", Op::subtract}}},
                                                            {{{"*", Op::multiply}, {"/", Op::divide}}}}};

bool starts_a_name(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Recursive descent; the operators of one level after the other.
class Parser {
 public:
  Parser(const std::string& text, const std::vector<std::string>& variables)
      : text_(text), variables_(variables) {}

  ExpressionProgram program() {
    choice();
    if (at_ < text_.size()) {
      if (text_[at_] == ',') wrong("has several values, separated by commas");
      if (text_[at_] == ')') wrong(fmt::format("the ')' at position {} closes nothing", at_ + 1));
      wrong(fmt::format("an operator is missing before '{}' at position {}", word(), at_ + 1));
    }
    if (program_.stack > ExpressionProgram::deepest_stack)
      wrong(fmt::format("needs more than {} values at a time", ExpressionProgram::deepest_stack));
    return std::move(program_);
  }

 private:
  [[noreturn]] static void wrong(const std::string& what) { throw std::invalid_argument(what); }

  struct Deeper {
    explicit Deeper(int& of) : depth(of) {
      if (++depth > 6 * deepest_nesting)
        wrong(fmt::format("is nested deeper than {} levels", deepest_nesting));
    }
    ~Deeper() { --depth; }
    Deeper(const Deeper&) = delete;
    Deeper& operator=(const Deeper&) = delete;
    int& depth;
  };

  void skip() {
    while (at_ < text_.size() && std::string_view(" \t\n\r").find(text_[at_]) != std::string_view::npos)
      ++at_;
  }
  bool take(std::string_view sign) {
    skip();
    if (std::string_view(text_).substr(at_, sign.size()) != sign) return false;
    at_ += sign.size();
    skip();
    return true;
  }
  /// What stands there, for messages.
  std::string word() const {
    std::size_t end = at_;
    while (end < text_.size() && (starts_a_name(text_[end]) || is_digit(text_[end]))) ++end;
    return text_.substr(at_, std::max<std::size_t>(end - at_, 1));
  }

  void emit(Op op, std::uint32_t at = 0, double number = 0) { program_.code.push_back({op, at, number}); }
  void push(Op op, std::uint32_t at, double number) {
    emit(op, at, number);
    program_.stack = std::max(program_.stack, ++depth_of_stack_);
  }
  void binary(Op op) {
    --depth_of_stack_;
    emit(op);
  }
  std::uint32_t here() const { return static_cast<std::uint32_t>(program_.code.size()); }

  /// condition ? value : value
  void choice() {
    const Deeper deeper(nesting_);
    level(0);
    if (!take("?")) return;
    const std::uint32_t to_other = here();
    emit(Op::jump_if_zero);
    --depth_of_stack_;
    choice();
    if (!take(":")) wrong("'?' has no ':'; a choice is written 'condition ? value : value'");
    const std::uint32_t to_end = here();
    emit(Op::jump);
    program_.code[to_other].at = here();
    --depth_of_stack_;  // one of the two
    choice();
    program_.code[to_end].at = here();
  }

  std::optional<Op> take_operator(std::size_t k) {
    for (const OperatorRow& row : levels[k])
      if (!row.sign.empty() && take(row.sign)) return row.op;
    return {};
  }

  void level(std::size_t k) {
    if (k == levels.size()) return sign();
    level(k + 1);
    while (const auto op = take_operator(k)) {
      level(k + 1);
      binary(*op);
    }
  }

  /// −x^2 is −(x^2).
  void sign() {
    const Deeper deeper(nesting_);
    if (take("-")) {
      const std::uint32_t before = here();
      sign();
      if (here() == before + 1 && program_.code.back().op == Op::number)
        program_.code.back().number = -program_.code.back().number;
      else
        emit(Op::negative);
    } else if (take("+")) {
      sign();
    } else {
      power();
    }
  }

  void power() {
    const Deeper deeper(nesting_);
    value();
    if (!take("^")) return;
    const std::uint32_t exponent = here();
    sign();  // from the right, with a sign of its own
    const auto& last = program_.code.back();
    if (here() == exponent + 1 && last.op == Op::number &&
        (last.number == 2 || last.number == 3 || last.number == 4)) {
      const Op op = last.number == 2 ? Op::square : last.number == 3 ? Op::cube : Op::fourth;
      program_.code.pop_back();
      --depth_of_stack_;
      emit(op);
    } else {
      binary(Op::power);
    }
  }

  void value() {
    skip();
    if (at_ == text_.size()) wrong("ends where a value is needed");
    const char c = text_[at_];
    if (take("(")) {
      choice();
      if (!take(")")) {
        if (at_ < text_.size() && text_[at_] == ',') wrong("has several values, separated by commas");
        missing_parenthesis();
      }
    } else if (is_digit(c) || c == '.') {
      number();
    } else if (starts_a_name(c)) {
      name();
    } else {
      wrong(fmt::format("'{}' at position {} stands where a value is needed", c, at_ + 1));
    }
  }

  [[noreturn]] void missing_parenthesis() const {
    if (at_ == text_.size()) wrong("a ')' is missing at the end");
    wrong(fmt::format("a ')' or an operator is missing before '{}' at position {}", word(), at_ + 1));
  }

  void number() {
    double x = 0;
    const char* const begin = text_.data() + at_;
    const auto [end, status] = std::from_chars(begin, text_.data() + text_.size(), x);
    if (status == std::errc::result_out_of_range)
      wrong(fmt::format("'{}' is too large or too small for a number", std::string(begin, end)));
    if (status != std::errc()) wrong(fmt::format("'{}' at position {} is no number", text_[at_], at_ + 1));
    at_ += static_cast<std::size_t>(end - begin);
    skip();
    push(Op::number, 0, x);
  }

  void name() {
    const std::size_t place = at_;
    const std::string name = word();
    at_ += name.size();
    skip();
    if (at_ < text_.size() && text_[at_] == '(') return call(name);
    const auto variable = std::find(variables_.begin(), variables_.end(), name);
    if (variable != variables_.end())
      return push(Op::variable, static_cast<std::uint32_t>(variable - variables_.begin()), 0);
    for (const ConstantRow& row : constants)
      if (row.name == name) return push(Op::number, 0, row.value);
    for (const FunctionRow& row : functions)
      if (row.name == name) wrong(fmt::format("'{}' at position {} has no '(' behind it", name, place + 1));
    std::vector<std::string> known = variables_;
    known.emplace_back("pi");
    for (const FunctionRow& row : functions) known.emplace_back(row.name);
    if (variables_.empty()) wrong(fmt::format("unknown name '{}'{}", name, did_you_mean(name, known)));
    wrong(fmt::format("unknown name '{}'{}; the variables here are: {}", name, did_you_mean(name, known),
                      fmt::join(variables_, ", ")));
  }

  void call(const std::string& name) {
    const auto* row = std::find_if(functions.begin(), functions.end(),
                                   [&](const FunctionRow& f) { return f.name == name; });
    if (row == functions.end()) {
      std::vector<std::string> known;
      for (const FunctionRow& f : functions) known.emplace_back(f.name);
      wrong(fmt::format("there is no function '{}'{}", name, did_you_mean(name, known)));
    }
    take("(");
    std::size_t count = 0;
    if (!take(")")) {
      for (;;) {
        choice();
        // min, max and sums are made as their arguments come.
        if (++count > 1 && row->arguments == 0) binary(row->op);
        if (take(")")) break;
        if (!take(",")) missing_parenthesis();
      }
    }
    if (row->arguments == 0 ? count == 0 : count != row->arguments)
      wrong(fmt::format("'{}' has {} argument{}; it takes {}", name, count, count == 1 ? "" : "s",
                        row->arguments == 0 ? "one or more" : fmt::format("{}", row->arguments)));
    if (name == "avg") emit(Op::divided_by_number, 0, static_cast<double>(count));
    if (row->arguments == 1) emit(row->op);
    if (row->arguments == 2) binary(row->op);
  }

  const std::string& text_;
  const std::vector<std::string>& variables_;
  ExpressionProgram program_;
  std::size_t at_ = 0, depth_of_stack_ = 0;
  int nesting_ = 0;
};

}  // namespace

ExpressionProgram parse_expression(const std::string& text, const std::vector<std::string>& variables) {
  return Parser(text, variables).program();
}

}  // namespace mimbre
