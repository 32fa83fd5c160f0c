#include "math/function_data.h"

#include "math/quadrature.h"

namespace mimbre {

double IntegralFunction::value(double x) const {
  const FunctionData& of = f.front();
  return start + (exact ? of.antiderivative(x) : table.value([&](double s) { return of.value(s); }, x));
}

double FunctionData::value(double x) const {
  if (const Pieces* pieces = std::get_if<Pieces>(&kind_)) return pieces->value(x);
  if (const OneVariable* formula = std::get_if<OneVariable>(&kind_)) return formula->value(x);
  if (const IntegralFunction* integral = std::get_if<IntegralFunction>(&kind_)) return integral->value(x);
  return 0;
}

double FunctionData::derivative(double x) const {
  if (const Pieces* pieces = std::get_if<Pieces>(&kind_)) return pieces->derivative(x);
  if (const OneVariable* formula = std::get_if<OneVariable>(&kind_)) return formula->jet(x).first;
  if (const IntegralFunction* integral = std::get_if<IntegralFunction>(&kind_))
    return integral->f.front().value(x);
  return 0;
}

double FunctionData::second_derivative(double x) const {
  if (const Pieces* pieces = std::get_if<Pieces>(&kind_)) return pieces->second_derivative(x);
  if (const OneVariable* formula = std::get_if<OneVariable>(&kind_)) return formula->jet(x).second;
  if (const IntegralFunction* integral = std::get_if<IntegralFunction>(&kind_))
    return integral->f.front().derivative(x);
  return 0;
}

Jet FunctionData::jet(double x) const {
  if (const OneVariable* formula = std::get_if<OneVariable>(&kind_)) return formula->jet(x);
  if (const IntegralFunction* integral = std::get_if<IntegralFunction>(&kind_)) {
    const auto [rate, second] = integral->f.front().tangent(x);
    return {integral->value(x), rate, second};
  }
  return {value(x), derivative(x), second_derivative(x)};
}

std::pair<double, double> FunctionData::tangent(double x) const {
  if (const OneVariable* formula = std::get_if<OneVariable>(&kind_)) {
    const Jet jet = formula->jet(x);
    return {jet.value, jet.first};
  }
  return {value(x), derivative(x)};
}

double FunctionData::antiderivative(double x) const {
  if (const Pieces* pieces = std::get_if<Pieces>(&kind_)) return pieces->antiderivative(x);
  if (const OneVariable* formula = std::get_if<OneVariable>(&kind_))
    return quadrature::integral([&](double s) { return formula->value(s); }, formula->integral_start, x);
  if (const IntegralFunction* integral = std::get_if<IntegralFunction>(&kind_))
    return quadrature::integral([&](double s) { return integral->value(s); }, 0, x);
  return 0;
}

}  // namespace mimbre
