#include "mimbre/function.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "math/function_data.h"
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
OneVariable one_variable(const std::string& text, const std::string& variable) {
  OneVariable made{compiled(text, {variable})};
  for (const double x : probes) {
    if (!std::isfinite(made.value(x))) continue;
    made.integral_start = x;
    return made;
  }
  throw InputError(Mark{}, fmt::format("expression '{}' is finite at none of {} = 0, ±0.01, ±0.1, ±1, ±10",
                                       text, variable));
}

}  // namespace

Function::Function(FunctionData data) : data_(std::make_shared<FunctionData>(std::move(data))) {}

const FunctionData& Function::data() const {
  static const FunctionData zero;
  return data_ ? *data_ : zero;
}

Function Function::constant(double value) { return polynomial({value}); }

Function Function::linear(double slope, double zero) {
  return Function(FunctionData(Pieces({}, {{zero, {0, slope}}})));
}

Function Function::polynomial(std::vector<double> coefficients) {
  return piecewise({}, {std::move(coefficients)});
}

Function Function::piecewise(std::vector<double> breaks, std::vector<std::vector<double>> pieces) {
  std::vector<Pieces::Piece> absolute;
  for (std::vector<double>& coefficients : pieces) absolute.push_back({0, std::move(coefficients)});
  return Function(FunctionData(Pieces(breaks, absolute)));
}

Function Function::piecewise(const std::vector<double>& breaks, const std::vector<double>& origins,
                             std::vector<std::vector<double>> pieces) {
  if (origins.size() != pieces.size())
    throw InputError(Mark{}, fmt::format("a function of {} pieces needs as many origins, not {}",
                                         pieces.size(), origins.size()));
  std::vector<Pieces::Piece> local;
  for (std::size_t k = 0; k < pieces.size(); ++k) local.push_back({origins[k], std::move(pieces[k])});
  return Function(FunctionData(Pieces(breaks, local)));
}

Function Function::table(std::vector<double> x, std::vector<double> y, Interpolation interpolation) {
  return Function(
      FunctionData(interpolation == Interpolation::cubic ? cubic_table(x, y) : linear_table(x, y)));
}

Function Function::expression(const std::string& text, const std::string& variable) {
  return Function(FunctionData(one_variable(text, variable)));
}

Function Function::repeated(double start, double period) const {
  if (!data_) return {};
  const Pieces* pieces = data_->pieces();
  if (!pieces)
    throw InputError(Mark{}, "an expression cannot be repeated; only tables and piecewise functions can");
  return Function(FunctionData(pieces->repeated(start, period)));
}

Function Function::integral(double start, double end) const {
  if (!data_) return constant(start);
  IntegralFunction made{{*data_}, start, data_->pieces() != nullptr, {}};
  if (!made.exact) made.table = IntegralTable([&](double x) { return value(x); }, end);
  return Function(FunctionData(std::move(made)));
}

double Function::value(double x) const { return data().value(x); }
double Function::derivative(double x) const { return data().derivative(x); }
double Function::second_derivative(double x) const { return data().second_derivative(x); }
Jet Function::jet(double x) const { return data().jet(x); }
std::pair<double, double> Function::tangent(double x) const { return data().tangent(x); }
double Function::antiderivative(double x) const { return data().antiderivative(x); }

Formula Formula::expression(const std::string& text, const std::vector<std::string>& variables) {
  Expression expression = compiled(text, variables);
  // All triples of these, the third for all the others too.
  std::vector<double> x(variables.size() + 3);
  for (const double a : probes)
    for (const double b : probes)
      for (const double c : probes) {
        std::fill(x.begin(), x.end(), c);
        x[0] = a;
        x[1] = b;
        if (!std::isfinite(expression.value(x.data()))) continue;
        Formula result;
        result.data_ = std::make_shared<Expression>(std::move(expression));
        return result;
      }
  throw InputError(Mark{}, fmt::format("expression '{}' is finite nowhere between -10 and 10", text));
}

const Expression& Formula::data() const {
  static const Expression zero;
  return data_ ? *data_ : zero;
}

double Formula::value(const double* x) const { return data().value(x); }
Jet Formula::jet(const Jet* x) const { return data().jet(x); }
Gradient Formula::gradient(const Gradient* x) const { return data().gradient(x); }
std::pair<double, double> Formula::derivatives(const double* x) const { return data().derivatives(x); }
std::size_t Formula::variables() const { return data().variables(); }

}  // namespace mimbre
