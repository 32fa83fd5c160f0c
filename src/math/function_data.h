#pragma once
#include <string>
#include <utility>
#include <variant>

#include "base/array.h"
#include "math/function_expression.h"
#include "math/function_integral.h"
#include "math/function_pieces.h"

namespace mimbre {

/// A formula of one variable.
struct OneVariable {
  Expression expression;
  double integral_start = 0;  ///< of its antiderivative: not 0 where it is not finite at 0, as 1/x

  double value(double x) const { return expression.value(&x); }
  Jet jet(double x) const {
    const Jet of{x, 1, 0};
    return expression.jet(&of);
  }
};

class FunctionData;
struct FunctionParts;

/// start + ∫ f from 0 to x.
struct IntegralFunction {
  Array<FunctionData> f;  ///< one
  double start = 0;
  bool exact = false;  ///< f knows its antiderivative, and the table is empty
  IntegralTable table;

  double value(double x) const;
};

/// What a Function evaluates, in arrays that an image can hold.
class FunctionData {
 public:
  FunctionData() = default;  ///< zero
  explicit FunctionData(Pieces pieces) : kind_(std::move(pieces)) {}
  explicit FunctionData(OneVariable formula) : kind_(std::move(formula)) {}
  explicit FunctionData(IntegralFunction integral) : kind_(std::move(integral)) {}

  double value(double x) const;
  double derivative(double x) const;
  double second_derivative(double x) const;
  Jet jet(double x) const;
  std::pair<double, double> tangent(double x) const;
  double antiderivative(double x) const;
  bool is_zero() const { return std::holds_alternative<std::monostate>(kind_); }
  const Pieces* pieces() const { return std::get_if<Pieces>(&kind_); }
  const OneVariable* formula() const { return std::get_if<OneVariable>(&kind_); }
  const IntegralFunction* integral() const { return std::get_if<IntegralFunction>(&kind_); }

 private:
  friend FunctionParts;
  std::variant<std::monostate, Pieces, OneVariable, IntegralFunction> kind_;
};

}  // namespace mimbre
