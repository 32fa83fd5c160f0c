#pragma once
#include <map>
#include <string>
#include <vector>

#include "model_file/text/value.h"

namespace mimbre::model_file {

/// A parameter of a model file as it was declared, with its value.
struct DeclaredParameter {
  std::string name, about;
  ParameterValue value;  ///< a number, or a word
  double min = 0, max = 0;
  bool integer = false, tunable = false;
  bool derived = false;  ///< its value is an expression of other parameters, and was not replaced
};

/// What a parameter may be: "a whole number from 1 to 9". ±infinity: no bound.
std::string range_text(double min, double max, bool integer);

/// Reads a `parameters` section into `scope` (whose outer scope may be the model's). `given` replaces values:
/// texts from the command line. What is in `given` but not among the parameters is an error that lists the
/// valid names. `declared` (optional) receives them in their order.
void read_parameters(const Value& section, const std::map<std::string, std::string>& given, Scope& scope,
                     std::vector<DeclaredParameter>* declared = nullptr);

/// Values that an instance hands to its template (`with`), evaluated among the model's parameters.
std::map<std::string, std::string> read_given(const Value& section);

/// Reports `given` parameters where the model has no parameters at all.
void report_unknown(const std::map<std::string, std::string>& given, const Scope& scope,
                    const Reading& reading);

/// `require`: conditions on the parameters with the message for who breaks them.
void read_requirements(const Value& section);

}  // namespace mimbre::model_file
