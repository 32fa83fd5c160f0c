#pragma once
#include <map>
#include <string>
#include <vector>

#include "app/options.h"

/// Values of inputs and tunable parameters that a command takes as NAME=VALUE.
namespace mimbre::app {

void add_start_inputs_option(Parser& parser, std::vector<std::string>& given);
/// By name; throws UsageError for a text that is no NAME=VALUE, for a name that is there twice and for a
/// value that is no finite number.
std::map<std::string, double> start_inputs(const std::vector<std::string>& given);

/// `text` as a finite number; throws UsageError(what).
double number_of(const std::string& text, const std::string& what);

}  // namespace mimbre::app
