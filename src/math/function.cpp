#include "mimbre/function.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <variant>

#include "math/function_difference.h"
#include "math/function_expression.h"
#include "math/function_integral.h"
#include "math/function_pieces.h"
#include "mimbre/diagnostics.h"

namespace mimbre {

namespace {

/// Where expressions are tried: an expression that is finite nowhere here is taken for a mistake.
constexpr std::array probes{0.0, 1.0, -1.0, 0.1, -0.1, 0.01, -0.01, 10.0, -10.0};

/// A difference of an expression near `at`, with the branches of `?:` that are taken there: the other ones
/// say nothing about it, and need not be finite. Where these are not finite beside `at`, all count.
template <class Difference>
double on_branch(const Expression& expression, std::span<const double, Expression::most_variables> at,
                 Difference&& difference) {
  using Values = std::span<const double, Expression::most_variables>;
  const auto as_it_is = [&](Values values) { return expression.value(values); };
  if (!expression.has_choices()) return difference(as_it_is);
  const Choices choices = expression.choices(at);
  const double result = difference([&](Values values) { return expression.value(values, choices); });
  return std::isfinite(result) ? result : difference(as_it_is);
}

/// An expression of one variable.
struct Formula {
  Formula(const std::string& text, const std::string& variable) : expression(text, {variable}) {
    for (const double x : probes) {
      if (!std::isfinite(value(x))) continue;
      integral_start = x;
      return;
    }
    throw InputError(Mark{}, fmt::format("expression '{}' is finite at none of {} = 0, ±0.01, ±0.1, ±1, ±10",
                                         text, variable));
  }
  double value(double x) const { return expression.value(std::array{x, 0.0, 0.0}); }
  double derivative(double x) const {
    return on_branch(expression, std::array{x, 0.0, 0.0}, [&](const auto& f) {
      return difference::first([&](double s) { return f(std::array{s, 0.0, 0.0}); }, x);
    });
  }
  double second_derivative(double x) const {
    return on_branch(expression, std::array{x, 0.0, 0.0}, [&](const auto& f) {
      return difference::second([&](double s) { return f(std::array{s, 0.0, 0.0}); }, x);
    });
  }

  Expression expression;
  double integral_start = 0;  ///< not 0 where the expression is not finite at 0, as 1/x
};

/// start + ∫ f from 0 to x.
struct Integral {
  Integral(const Function& of, double value_at_0, double end)
      : f(of), start(value_at_0), table([&](double x) { return of.value(x); }, end) {}
  Integral(const Function& of, double value_at_0) : f(of), start(value_at_0), exact(true) {}
  double value(double x) const {
    return start + (exact ? f.antiderivative(x) : table.value([&](double s) { return f.value(s); }, x));
  }

  Function f;
  double start = 0;
  bool exact = false;  ///< f knows its antiderivative
  IntegralTable table;
};

}  // namespace

struct Function::Impl {
  explicit Impl(Pieces pieces) : kind(std::move(pieces)) {}
  Impl(const std::string& text, const std::string& variable)
      : kind(std::in_place_type<Formula>, text, variable) {}
  explicit Impl(Integral integral) : kind(std::move(integral)) {}
  std::variant<Pieces, Formula, Integral> kind;
};

Function Function::constant(double value) { return polynomial({value}); }

Function Function::linear(double slope, double zero) {
  Function result;
  result.impl_ = std::make_shared<Impl>(Pieces({}, {{zero, {0, slope}}}));
  return result;
}

Function Function::polynomial(std::vector<double> coefficients) {
  return piecewise({}, {std::move(coefficients)});
}

Function Function::piecewise(std::vector<double> breaks, std::vector<std::vector<double>> pieces) {
  std::vector<Pieces::Piece> absolute;
  for (std::vector<double>& coefficients : pieces) absolute.push_back({0, std::move(coefficients)});
  Function result;
  result.impl_ = std::make_shared<Impl>(Pieces(std::move(breaks), absolute));
  return result;
}

Function Function::table(std::vector<double> x, std::vector<double> y, Interpolation interpolation) {
  Function result;
  result.impl_ =
      std::make_shared<Impl>(interpolation == Interpolation::cubic ? cubic_table(x, y) : linear_table(x, y));
  return result;
}

Function Function::expression(const std::string& text, const std::string& variable) {
  Function result;
  result.impl_ = std::make_shared<Impl>(text, variable);
  return result;
}

Function Function::repeated(double start, double period) const {
  if (!impl_) return {};
  const Pieces* pieces = std::get_if<Pieces>(&impl_->kind);
  if (!pieces)
    throw InputError(Mark{}, "an expression cannot be repeated; only tables and piecewise functions can");
  Function result;
  result.impl_ = std::make_shared<Impl>(pieces->repeated(start, period));
  return result;
}

Function Function::integral(double start, double end) const {
  if (!impl_) return constant(start);
  Function result;
  result.impl_ = std::make_shared<Impl>(
      std::holds_alternative<Pieces>(impl_->kind) ? Integral(*this, start) : Integral(*this, start, end));
  return result;
}

double Function::value(double x) const {
  if (!impl_) return 0;
  if (const Pieces* pieces = std::get_if<Pieces>(&impl_->kind)) return pieces->value(x);
  if (const Integral* integral = std::get_if<Integral>(&impl_->kind)) return integral->value(x);
  return std::get_if<Formula>(&impl_->kind)->value(x);
}

double Function::derivative(double x) const {
  if (!impl_) return 0;
  if (const Pieces* pieces = std::get_if<Pieces>(&impl_->kind)) return pieces->derivative(x);
  if (const Integral* integral = std::get_if<Integral>(&impl_->kind)) return integral->f.value(x);
  return std::get_if<Formula>(&impl_->kind)->derivative(x);
}

double Function::second_derivative(double x) const {
  if (!impl_) return 0;
  if (const Pieces* pieces = std::get_if<Pieces>(&impl_->kind)) return pieces->second_derivative(x);
  if (const Integral* integral = std::get_if<Integral>(&impl_->kind)) return integral->f.derivative(x);
  return std::get_if<Formula>(&impl_->kind)->second_derivative(x);
}

double Function::antiderivative(double x) const {
  if (!impl_) return 0;
  if (const Pieces* pieces = std::get_if<Pieces>(&impl_->kind)) return pieces->antiderivative(x);
  if (const Integral* integral = std::get_if<Integral>(&impl_->kind))
    return difference::integral([&](double s) { return integral->value(s); }, 0, x);
  const Formula& formula = *std::get_if<Formula>(&impl_->kind);
  return difference::integral([&](double s) { return formula.value(s); }, formula.integral_start, x);
}

struct Function3::Impl {
  Impl(const std::string& text, const std::vector<std::string>& variables) : expression(text, variables) {
    for (const double a : probes)
      for (const double b : probes)
        for (const double c : probes)
          if (std::isfinite(expression.value(std::array{a, b, c}))) return;
    throw InputError(Mark{}, fmt::format("expression '{}' is finite nowhere between -10 and 10", text));
  }
  Expression expression;
};

Function3 Function3::expression(const std::string& text, const std::vector<std::string>& variables) {
  Function3 result;
  result.impl_ = std::make_shared<Impl>(text, variables);
  return result;
}

double Function3::value(double a, double b, double c) const {
  return impl_ ? impl_->expression.value(std::array{a, b, c}) : 0;
}

std::pair<double, double> Function3::derivatives(double a, double b, double c) const {
  if (!impl_) return {0, 0};
  const auto along = [&](std::size_t k) {
    const std::array at{a, b, c};
    return on_branch(impl_->expression, at, [&](const auto& f) {
      return difference::first(
          [&](double s) {
            auto moved = at;
            moved[k] = s;
            return f(moved);
          },
          at[k]);
    });
  };
  return {along(0), along(1)};
}

}  // namespace mimbre
