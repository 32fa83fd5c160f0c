#include "math/function_expression.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "math/elementary.h"

namespace mimbre {

namespace {

using Op = ExpressionProgram::Op;

constexpr std::size_t longest_text = 10000;
constexpr int deepest_brackets = 100;

[[noreturn]] void refuse(const std::string& why) { throw std::invalid_argument(why); }

/// Deep nesting and great length are limited so that hostile input stays cheap.
void check_text(const std::string& text) {
  if (text.size() > longest_text)
    refuse(fmt::format("has {} characters, at most {} are allowed", text.size(), longest_text));
  int depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool printable = static_cast<unsigned char>(c) >= 0x20 && static_cast<unsigned char>(c) < 0x7f;
    if (!printable && c != '\t' && c != '\n' && c != '\r')
      refuse(fmt::format("unexpected character at position {}", i + 1));
    if (c == '"' || c == '\'') refuse("quotes are not allowed");
    if (c == '(' || c == '?') ++depth;
    if (c == ')') --depth;
    if (depth > deepest_brackets) refuse(fmt::format("is nested deeper than {} levels", deepest_brackets));
    if (c != '=') continue;
    const bool second_half =
        i > 0 && (text[i - 1] == '=' || text[i - 1] == '<' || text[i - 1] == '>' || text[i - 1] == '!');
    const bool first_half = i + 1 < text.size() && text[i + 1] == '=';
    if (!second_half && !first_half) refuse("'=' assigns; to compare, write '=='");
  }
}

double sign_of(double x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }

double value_at(Op op, double x) {
  switch (op) {
    case Op::square:
      return x * x;
    case Op::cube:
      return x * x * x;
    case Op::fourth:
      return x * x * x * x;
    case Op::sin:
      return mimbre::sin(x);
    case Op::cos:
      return mimbre::cos(x);
    case Op::tan:
      return mimbre::tan(x);
    case Op::asin:
      return mimbre::asin(x);
    case Op::acos:
      return mimbre::acos(x);
    case Op::atan:
      return mimbre::atan(x);
    case Op::sinh:
      return mimbre::sinh(x);
    case Op::cosh:
      return mimbre::cosh(x);
    case Op::tanh:
      return mimbre::tanh(x);
    case Op::asinh:
      return mimbre::asinh(x);
    case Op::acosh:
      return mimbre::acosh(x);
    case Op::atanh:
      return mimbre::atanh(x);
    case Op::log2:
      return mimbre::log2(x);
    case Op::log10:
      return mimbre::log10(x);
    case Op::ln:
      return mimbre::log(x);
    case Op::exp:
      return mimbre::exp(x);
    case Op::sqrt:
      return std::sqrt(x);
    case Op::sign:
      return sign_of(x);
    case Op::rint:
      return std::nearbyint(x);
    default:  // abs
      return std::abs(x);
  }
}

Taylor taylor_at(Op op, double x) {
  const double f = value_at(op, x);
  const auto logarithm = [&](double base) { return Taylor{f, 1 / (x * base), -1 / (x * x * base)}; };
  switch (op) {
    case Op::square:
      return {f, 2 * x, 2};
    case Op::cube:
      return {f, 3 * x * x, 6 * x};
    case Op::fourth:
      return {f, 4 * x * x * x, 12 * x * x};
    case Op::sin:
      return {f, mimbre::cos(x), -f};
    case Op::cos:
      return {f, -mimbre::sin(x), -f};
    case Op::tan:
      return {f, 1 + f * f, 2 * f * (1 + f * f)};
    case Op::asin:
    case Op::acos: {
      const double c = 1 - x * x, slope = (op == Op::asin ? 1 : -1) / std::sqrt(c);
      return {f, slope, slope * x / c};
    }
    case Op::atan: {
      const double slope = 1 / (1 + x * x);
      return {f, slope, -2 * x * slope * slope};
    }
    case Op::sinh:
      return {f, mimbre::cosh(x), f};
    case Op::cosh:
      return {f, mimbre::sinh(x), f};
    case Op::tanh: {
      // 1 − tanh² without cancellation.
      const double slope = 1 / (mimbre::cosh(x) * mimbre::cosh(x));
      return {f, slope, -2 * f * slope};
    }
    case Op::asinh: {
      const double c = 1 + x * x, slope = 1 / std::sqrt(c);
      return {f, slope, -slope * x / c};
    }
    case Op::acosh: {
      const double c = (x - 1) * (x + 1), slope = 1 / std::sqrt(c);
      return {f, slope, -slope * x / c};
    }
    case Op::atanh: {
      const double slope = 1 / ((1 - x) * (1 + x));
      return {f, slope, 2 * x * slope * slope};
    }
    case Op::log2:
      return logarithm(std::numbers::ln2);
    case Op::log10:
      return logarithm(std::numbers::ln10);
    case Op::ln:
      return logarithm(1);
    case Op::exp:
      return {f, f, f};
    case Op::sqrt:
      return {f, 0.5 / f, -0.25 / (f * x)};
    case Op::abs:
      return {f, sign_of(x), 0};
    default:  // sign, rint
      return {f, 0, 0};
  }
}

double unary(Op op, double x) { return value_at(op, x); }
template <class Scalar>
Scalar unary(Op op, const Scalar& x) {
  return chain(taylor_at(op, value_of(x)), x);
}

Jet constant(double value) { return {value, 0, 0}; }

/// f' of a jet.
Jet slope(Op op, const Jet& x) {
  const Jet one = constant(1);
  const auto logarithm = [&](double base) { return one / (constant(base) * x); };
  switch (op) {
    case Op::square:
      return constant(2) * x;
    case Op::cube:
      return constant(3) * unary(Op::square, x);
    case Op::fourth:
      return constant(4) * unary(Op::cube, x);
    case Op::sin:
      return unary(Op::cos, x);
    case Op::cos:
      return -unary(Op::sin, x);
    case Op::tan:
      return one + unary(Op::square, unary(Op::tan, x));
    case Op::asin:
      return one / unary(Op::sqrt, one - x * x);
    case Op::acos:
      return -(one / unary(Op::sqrt, one - x * x));
    case Op::atan:
      return one / (one + x * x);
    case Op::sinh:
      return unary(Op::cosh, x);
    case Op::cosh:
      return unary(Op::sinh, x);
    case Op::tanh:
      return one / unary(Op::square, unary(Op::cosh, x));
    case Op::asinh:
      return one / unary(Op::sqrt, one + x * x);
    case Op::acosh:
      return one / unary(Op::sqrt, (x - one) * (x + one));
    case Op::atanh:
      return one / ((one - x) * (one + x));
    case Op::log2:
      return logarithm(std::numbers::ln2);
    case Op::log10:
      return logarithm(std::numbers::ln10);
    case Op::ln:
      return logarithm(1);
    case Op::exp:
      return unary(Op::exp, x);
    case Op::sqrt:
      return constant(0.5) / unary(Op::sqrt, x);
    case Op::abs:
      return constant(sign_of(x.value));
    default:  // sign, rint
      return constant(0);
  }
}
VaryingJet unary(Op op, const VaryingJet& x) {
  const Jet none = constant(0);
  return {unary(op, x.at), varies(VaryingJet{none, x.by}) ? along(slope(op, x.at), x.by) : none};
}

double power(double a, double b) { return mimbre::pow(a, b); }
template <class Scalar>
Scalar power(const Scalar& a, const Scalar& b) {
  const double x = a.value, n = b.value, f = mimbre::pow(x, n);
  if (!varies(b) || x == 0) {
    const double f1 = n == 0 ? 0 : n * mimbre::pow(x, n - 1);
    return chain({f, f1, n == 0 || n == 1 ? 0 : n * (n - 1) * mimbre::pow(x, n - 2)}, a);
  }
  Scalar result = chain({f, f, f}, b * unary(Op::ln, a));  // exp(b ln a)
  result.value = f;
  return result;
}

VaryingJet power(const VaryingJet& a, const VaryingJet& b) {
  const double n = b.at.value;
  if (!varies(b) || a.at.value == 0)
    return {power(a.at, b.at),
            n == 0 ? constant(0) : along(constant(n) * power(a.at, constant(n - 1)), a.by)};
  const VaryingJet exponent = b * unary(Op::ln, a);
  const Jet f = power(a.at, b.at);
  return {f, along(f, exponent.by)};
}

double arc_tangent(double y, double x) { return mimbre::atan2(y, x); }
Gradient arc_tangent(const Gradient& y, const Gradient& x) {
  const double s = x.value * x.value + y.value * y.value;
  return {mimbre::atan2(y.value, x.value), (x.value * y.by_first - y.value * x.by_first) / s,
          (x.value * y.by_second - y.value * x.by_second) / s};
}
Jet arc_tangent(const Jet& y, const Jet& x) {
  const double s = x.value * x.value + y.value * y.value;
  const double first = (x.value * y.first - y.value * x.first) / s;
  return {
      mimbre::atan2(y.value, x.value), first,
      (x.value * y.second - y.value * x.second - 2 * (x.value * x.first + y.value * y.first) * first) / s};
}

VaryingJet arc_tangent(const VaryingJet& y, const VaryingJet& x) {
  const Jet s = x.at * x.at + y.at * y.at;
  return {arc_tangent(y.at, x.at), (along(x.at, y.by) - along(y.at, x.by)) / s};
}

double mean(double a, double) { return a; }
/// `a` where it is smaller by `sign` times.
template <class Scalar>
Scalar least(const Scalar& a, const Scalar& b, double sign) {
  const double x = sign * value_of(a), y = sign * value_of(b);
  return x < y ? a : y < x ? b : x == y ? mean(a, b) : (std::isnan(x) ? a : b);
}

bool holds(Op op, double a, double b) {
  switch (op) {
    case Op::less:
      return a < b;
    case Op::greater:
      return a > b;
    case Op::less_or_equal:
      return a <= b;
    case Op::greater_or_equal:
      return a >= b;
    case Op::equal:
      return a == b;
    case Op::not_equal:
      return a != b;
    case Op::both:
      return a != 0 && b != 0;
    default:  // either
      return a != 0 || b != 0;
  }
}

template <class Scalar>
Scalar run(const ExpressionProgram& program, const Scalar* variables) {
  std::array<Scalar, ExpressionProgram::deepest_stack + 1> stack;
  Scalar* top = stack.data();  // below the first
  const std::size_t end = program.code.size();
  for (std::size_t at = 0; at < end; ++at) {
    const ExpressionProgram::Instruction& i = program.code[at];
    switch (i.op) {
      case Op::number:
        set_constant(*++top, i.number);
        break;
      case Op::variable:
        *++top = variables[i.at];
        break;
      case Op::negative:
        *top = -*top;
        break;
      case Op::divided_by_number: {
        Scalar count;
        set_constant(count, i.number);
        *top = *top / count;
        break;
      }
      case Op::add:
        --top;
        *top = top[0] + top[1];
        break;
      case Op::subtract:
        --top;
        *top = top[0] - top[1];
        break;
      case Op::multiply:
        --top;
        *top = top[0] * top[1];
        break;
      case Op::divide:
        --top;
        *top = top[0] / top[1];
        break;
      case Op::power:
        --top;
        *top = power(top[0], top[1]);
        break;
      case Op::atan2:
        --top;
        *top = arc_tangent(top[0], top[1]);
        break;
      case Op::min:
        --top;
        *top = least(top[0], top[1], 1);
        break;
      case Op::max:
        --top;
        *top = least(top[0], top[1], -1);
        break;
      case Op::less:
      case Op::greater:
      case Op::less_or_equal:
      case Op::greater_or_equal:
      case Op::equal:
      case Op::not_equal:
      case Op::both:
      case Op::either:
        --top;
        set_constant(*top, holds(i.op, value_of(top[0]), value_of(top[1])) ? 1 : 0);
        break;
      case Op::jump:
        at = i.at - 1;
        break;
      case Op::jump_if_zero:
        if (value_of(*top--) == 0) at = i.at - 1;
        break;
      default:
        *top = unary(i.op, *top);
    }
  }
  return *top;
}

}  // namespace

Expression::Expression(const std::string& text, const std::vector<std::string>& variables) {
  if (variables.size() > Formula::most_variables)
    refuse(fmt::format("an expression has up to {} variables, not {}", Formula::most_variables,
                       variables.size()));
  check_text(text);
  if (std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isspace(c); }))
    refuse("is empty");
  program_ = parse_expression(text, variables);
  variables_ = variables.size();
}

double Expression::value(const double* variables) const {
  return is_zero() ? 0 : run<double>(program_, variables);
}
Jet Expression::jet(const Jet* variables) const {
  return is_zero() ? Jet{0, 0, 0} : run<Jet>(program_, variables);
}
Gradient Expression::gradient(const Gradient* variables) const {
  return is_zero() ? Gradient{0, 0, 0} : run<Gradient>(program_, variables);
}

VaryingJet Expression::jet(const VaryingJet* variables) const {
  return is_zero() ? VaryingJet{{0, 0, 0}, {0, 0, 0}} : run<VaryingJet>(program_, variables);
}

std::pair<double, double> Expression::derivatives(const double* variables) const {
  std::array<Gradient, Formula::most_variables> of;
  for (std::size_t k = 0; k < variables_; ++k) of[k] = {variables[k], k == 0 ? 1.0 : 0.0, k == 1 ? 1.0 : 0.0};
  const Gradient g = gradient(of.data());
  return {g.by_first, g.by_second};
}

}  // namespace mimbre
