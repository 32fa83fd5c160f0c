#pragma once
#include <array>
#include <span>
#include <string>
#include <vector>

#include "math/expression_program.h"
#include "math/jet.h"

namespace mimbre {

/// A formula in up to three variables, compiled once. Evaluation neither allocates nor throws nor locks, and
/// any number of threads may share it. Derivatives are exact, those of the branch that `?:` takes; at a kink
/// of abs, min or max the mean of both sides, across a jump those of either side.
class Expression {
 public:
  /// Throws std::invalid_argument, which says why, when the text is not a formula in these variables, has
  /// more than 10 000 characters or 100 nested levels.
  Expression(const std::string& text, const std::vector<std::string>& variables);

  static constexpr std::size_t most_variables = 3;
  /// One value per variable, in their order; surplus values are ignored.
  double value(std::span<const double, most_variables> values) const;
  /// With the derivatives by the first variable.
  Jet jet(std::span<const double, most_variables> values) const;
  /// With the derivatives by the first and the second variable.
  Gradient gradient(std::span<const double, most_variables> values) const;

 private:
  ExpressionProgram program_;
};

}  // namespace mimbre
