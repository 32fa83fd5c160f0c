#pragma once
#include <map>
#include <string>

#include "model_file/text/value.h"

namespace mimbre::model_file {

/// Reads a `parameters` section into `scope` (whose outer scope may be the model's). `given` replaces values:
/// texts from the command line. What is in `given` but not among the parameters is an error that lists the
/// valid names.
void read_parameters(const Value& section, const std::map<std::string, std::string>& given, Scope& scope);

/// Values that an instance hands to its template (`with`), evaluated among the model's parameters.
std::map<std::string, std::string> read_given(const Value& section);

/// Reports `given` parameters where the model has no parameters at all.
void report_unknown(const std::map<std::string, std::string>& given, const Scope& scope,
                    const Reading& reading);

/// `require`: conditions on the parameters with the message for who breaks them.
void read_requirements(const Value& section);

}  // namespace mimbre::model_file
