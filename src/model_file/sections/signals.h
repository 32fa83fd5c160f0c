#pragma once
#include "model_file/text/builder.h"

/// Inputs, signals and outputs in the expressions of laws.
namespace mimbre::model_file {

/// A text in which each name of an input, a signal or an output is replaced by a variable of its own.
struct SignalText {
  std::string text;
  std::vector<Variable> variables;
  std::vector<spec::Source> sources;  ///< by variable
  bool any() const { return !sources.empty(); }
};
SignalText replace_signals(Builder& builder, const Part& part, const std::string& text);

/// Whether a text uses any.
bool uses_signals(Builder& builder, const Part& part, const Value& value);

/// factor · an expression of own variables and signals.
struct FormulaTerm {
  Value value;
  std::vector<Variable> variables;  ///< its own
  double factor = 1;
  std::optional<Quantity> of = {};  ///< what it measures, where that is not what the sum does
};

/// A law of own variables: the sum of the terms, with all signals that they use. Nothing, and an error, where
/// it is none.
std::optional<spec::Law> read_formula(Builder& builder, const Part& part,
                                      const std::vector<FormulaTerm>& terms,
                                      const std::vector<std::string>& own, const Quantity& wanted);

/// A law of one variable, named `as`, as a term of a formula, where it uses signals; else false, and it is to
/// be read without.
bool add_term_with_signals(Builder& builder, const Part& part, const Value& law, LawOf of, const char* as,
                           std::vector<FormulaTerm>& terms);

/// The signal that a text of time and signals stands for: one that is made for it. -1, and an error, where it
/// is none.
int anonymous_signal(Builder& builder, const Part& part, const Value& value, const std::string& name,
                     const Quantity& wanted);

/// Names of inputs, tunable parameters, signals and outputs, before anything uses them; then what signals
/// are, and which outputs are seen.
void read_inputs(Builder& builder, Part& part);
/// Records an error for a name that expressions cannot have; false then.
bool claim_variable(Builder& builder, Names& names, const Part& part, const std::string& full_name,
                    const std::string& name, const Mark& mark, int index);
void claim_signals(Builder& builder, Part& part);
void claim_outputs(Builder& builder, Part& part);
void read_signals(Builder& builder, Part& part);
void read_events(Builder& builder, Part& part);
void resolve_sensors(Builder& builder);

/// An output's description without its name, for a signal that sees it.
bool read_sensor(Builder& builder, const Part& part, const Value& value, spec::Output& output);
/// "front.{instance}" with the part's name in it.
std::string instance_name(std::string text, const std::string& instance);

}  // namespace mimbre::model_file
