#pragma once
#include <string>
#include <utility>
#include <vector>

#include "math/expression_program.h"
#include "math/jet.h"
#include "math/varying_jet.h"

namespace mimbre {

struct FunctionParts;

/// A formula in some variables, compiled once. Evaluation neither allocates nor throws nor locks, and
/// any number of threads may share it. Derivatives are exact, those of the branch that `?:` takes; at a kink
/// of abs, min or max the mean of both sides, across a jump those of either side.
class Expression {
 public:
  Expression() = default;  ///< zero
  /// Throws std::invalid_argument, with the reason, when the text is not a formula in these variables, has
  /// more than 10 000 characters or 100 nested levels.
  Expression(const std::string& text, const std::vector<std::string>& variables);

  /// One value per variable, in their order.
  double value(const double* variables) const;
  /// With the derivatives by what the variables depend on.
  Jet jet(const Jet* variables) const;
  Gradient gradient(const Gradient* variables) const;
  VaryingJet jet(const VaryingJet* variables) const;
  /// ∂/∂variables[0] and ∂/∂variables[1].
  std::pair<double, double> derivatives(const double* variables) const;
  std::size_t variables() const { return variables_; }
  bool is_zero() const { return program_.code.empty(); }
  const ExpressionProgram& program() const { return program_; }

 private:
  friend FunctionParts;
  ExpressionProgram program_;
  std::size_t variables_ = 0;
};

}  // namespace mimbre
