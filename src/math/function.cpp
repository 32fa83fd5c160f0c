#include "mimbre/function.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <variant>

#include "math/function_expression.h"
#include "math/function_integral.h"
#include "math/function_pieces.h"
#include "math/quadrature.h"
#include "mimbre/diagnostics.h"

namespace mimbre {

namespace {

/// Where expressions are tried: an expression that is finite nowhere here is taken for a mistake.
constexpr std::array probes{0.0, 1.0, -1.0, 0.1, -0.1, 0.01, -0.01, 10.0, -10.0};

/// For messages: the beginning of the text, on one line.
std::string shortened(std::string text) {
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20; }, ' ');
  return text;
}

Expression compiled(const std::string& text, const std::vector<std::string>& variables) {
  try {
    return {text, variables};
  } catch (const std::invalid_argument& error) {
    throw InputError(Mark{}, fmt::format("expression '{}': {}", shortened(text), error.what()));
  }
}

/// An expression of one variable.
struct OneVariable {
  OneVariable(const std::string& text, const std::string& variable) : expression(compiled(text, {variable})) {
    for (const double x : probes) {
      if (!std::isfinite(value(x))) continue;
      integral_start = x;
      return;
    }
    throw InputError(Mark{}, fmt::format("expression '{}' is finite at none of {} = 0, ±0.01, ±0.1, ±1, ±10",
                                         text, variable));
  }
  double value(double x) const { return expression.value(&x); }
  Jet jet(double x) const {
    const Jet of{x, 1, 0};
    return expression.jet(&of);
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
      : kind(std::in_place_type<OneVariable>, text, variable) {}
  explicit Impl(Integral integral) : kind(std::move(integral)) {}
  std::variant<Pieces, OneVariable, Integral> kind;
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
  return std::get_if<OneVariable>(&impl_->kind)->value(x);
}

double Function::derivative(double x) const {
  if (!impl_) return 0;
  if (const Pieces* pieces = std::get_if<Pieces>(&impl_->kind)) return pieces->derivative(x);
  if (const Integral* integral = std::get_if<Integral>(&impl_->kind)) return integral->f.value(x);
  return std::get_if<OneVariable>(&impl_->kind)->jet(x).first;
}

double Function::second_derivative(double x) const {
  if (!impl_) return 0;
  if (const Pieces* pieces = std::get_if<Pieces>(&impl_->kind)) return pieces->second_derivative(x);
  if (const Integral* integral = std::get_if<Integral>(&impl_->kind)) return integral->f.derivative(x);
  return std::get_if<OneVariable>(&impl_->kind)->jet(x).second;
}

Jet Function::jet(double x) const {
  if (!impl_) return {0, 0, 0};
  if (const OneVariable* formula = std::get_if<OneVariable>(&impl_->kind)) return formula->jet(x);
  if (const Integral* integral = std::get_if<Integral>(&impl_->kind)) {
    const auto [rate, second] = integral->f.tangent(x);
    return {integral->value(x), rate, second};
  }
  return {value(x), derivative(x), second_derivative(x)};
}

std::pair<double, double> Function::tangent(double x) const {
  if (!impl_) return {0, 0};
  if (const OneVariable* formula = std::get_if<OneVariable>(&impl_->kind)) {
    const Jet jet = formula->jet(x);
    return {jet.value, jet.first};
  }
  return {value(x), derivative(x)};
}

double Function::antiderivative(double x) const {
  if (!impl_) return 0;
  if (const Pieces* pieces = std::get_if<Pieces>(&impl_->kind)) return pieces->antiderivative(x);
  if (const Integral* integral = std::get_if<Integral>(&impl_->kind))
    return quadrature::integral([&](double s) { return integral->value(s); }, 0, x);
  const OneVariable& formula = *std::get_if<OneVariable>(&impl_->kind);
  return quadrature::integral([&](double s) { return formula.value(s); }, formula.integral_start, x);
}

struct Formula::Impl {
  Impl(const std::string& text, const std::vector<std::string>& variables)
      : expression(compiled(text, variables)) {
    // All triples of these, the third for all the others too.
    std::vector<double> x(variables.size() + 3);
    for (const double a : probes)
      for (const double b : probes)
        for (const double c : probes) {
          std::fill(x.begin(), x.end(), c);
          x[0] = a;
          x[1] = b;
          if (std::isfinite(expression.value(x.data()))) return;
        }
    throw InputError(Mark{}, fmt::format("expression '{}' is finite nowhere between -10 and 10", text));
  }
  Expression expression;
};

Formula Formula::expression(const std::string& text, const std::vector<std::string>& variables) {
  Formula result;
  result.impl_ = std::make_shared<Impl>(text, variables);
  return result;
}

double Formula::value(const double* x) const { return impl_ ? impl_->expression.value(x) : 0; }
Jet Formula::jet(const Jet* x) const { return impl_ ? impl_->expression.jet(x) : Jet{0, 0, 0}; }
Gradient Formula::gradient(const Gradient* x) const {
  return impl_ ? impl_->expression.gradient(x) : Gradient{0, 0, 0};
}
std::size_t Formula::variables() const { return impl_ ? impl_->expression.variables() : 0; }

std::pair<double, double> Formula::derivatives(const double* x) const {
  if (!impl_) return {0, 0};
  std::array<Gradient, most_variables> of;
  for (std::size_t k = 0; k < variables(); ++k) of[k] = {x[k], k == 0 ? 1.0 : 0.0, k == 1 ? 1.0 : 0.0};
  const Gradient g = gradient(of.data());
  return {g.by_first, g.by_second};
}

}  // namespace mimbre
