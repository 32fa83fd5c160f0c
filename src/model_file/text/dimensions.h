#pragma once
#include <string>

#include "model_file/text/expression.h"

namespace mimbre::model_file {

/// Throws ExpressionError where the units in an expression do not go together, or not with what is wanted.
/// What has no unit: plain numbers are pure factors beside numbers with units and SI in sums with them;
/// parameters are whatever fits. An expression without any unit is not looked at.
void check_dimensions(const std::string& text, const Scope& scope, const std::vector<Variable>& variables,
                      const Quantity& wanted);

}  // namespace mimbre::model_file
