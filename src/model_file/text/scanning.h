#pragma once
#include <optional>
#include <string>
#include <vector>

#include "model_file/text/expression.h"

/// The words of an expression: what who replaces parameters and who looks at units both need.
namespace mimbre::model_file {

bool starts_name(char c);
bool is_digit(char c);
/// Behind the name, or the number, that starts at `i`.
std::size_t name_end(const std::string& text, std::size_t i);
std::size_t number_end(const std::string& text, std::size_t i);

/// The variable that the file calls `name`; null where that is none.
const Variable* find_variable(const std::string& name, const std::vector<Variable>& variables);

/// The unit behind the number that ends at `i`, blanks between. Throws ExpressionError where a name stands
/// there that is no unit, and reports what would be right for a number that is `wanted`.
std::optional<WrittenUnit> unit_behind(const std::string& text, std::size_t i, const Scope& scope,
                                       const std::vector<Variable>& variables, const Quantity& wanted);

}  // namespace mimbre::model_file
