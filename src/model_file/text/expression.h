#pragma once
#include <map>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "mimbre/diagnostics.h"
#include "model_file/text/units.h"

namespace mimbre::model_file {

/// The value of a parameter: a number (booleans are 1 and 0) or a word.
using ParameterValue = std::variant<double, std::string>;

/// Parameters that are visible at a place: a template's own first, then the model's.
struct Scope {
  const Scope* outer = nullptr;
  std::map<std::string, ParameterValue> values;
  /// Words that parameters may have, numbered, so that expressions can compare them: `arms == flexible`.
  std::map<std::string, int> words;
  std::map<std::string, std::string> chosen_by;  ///< of the choices among them: whose, the first parameter's
  /// Parameters that may change during a run: only laws and signals can use them.
  struct Tunable {
    double start = 0, min = 0, max = 0;
    Mark mark;
  };
  std::map<std::string, Tunable> tunables;

  bool is_tunable(const std::string& name) const;
  const ParameterValue* find(const std::string& name) const;
  const int* find_word(const std::string& word) const;
  /// The parameter of which the word is a choice; null: none.
  const std::string* chooser_of(const std::string& word) const;
  std::vector<std::string> names() const;
};

/// What is wrong with an expression, in words for the user.
struct ExpressionError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

bool is_function_name(const std::string& name);

/// What the expressions of laws call their variables, by what these are called in the result: a length is `l`
/// or `x`.
struct Variable {
  std::string name;                ///< in the result
  std::vector<std::string> names;  ///< in the file, the preferred one first
  Quantity quantity = quantity::any;
};

/// The variables of a law of a length or another coordinate, of a rate, of time, and of all three.
enum class LawOf { coordinate, rate, time, all };
/// `x`: what the law's one variable measures.
std::vector<Variable> variables_of(LawOf law, const Quantity& x = quantity::any);

/// Whether it is the name of a variable in any law.
bool is_variable_name(const std::string& name);

/// The expression with parameters replaced by their values and numbers with units by SI ones, so that only
/// `variables` and functions are left. Throws ExpressionError on unknown names, on units that do not fit what
/// is `wanted`, and on what is no part of an expression.
std::string substitute_parameters(const std::string& text, const Scope& scope,
                                  const std::vector<Variable>& variables, const Quantity& wanted);

/// The finite value in SI of an expression over parameters. Throws ExpressionError.
double evaluate(const std::string& text, const Scope& scope, const Quantity& wanted = quantity::number);

/// A text value: `$name` is the parameter's value, `condition ? word : word` one of the words, anything else
/// itself.
std::string evaluate_word(const std::string& text, const Scope& scope);

/// A parameter's value as one writes it.
std::string to_text(const ParameterValue& value);

}  // namespace mimbre::model_file
