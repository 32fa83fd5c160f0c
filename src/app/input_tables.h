#pragma once
#include <map>
#include <string>
#include <vector>

#include "app/options.h"
#include "mimbre/recorded_inputs.h"

/// Inputs that a run plays from files with tables.
namespace mimbre::app {

struct InputTables {
  RecordedInputs tables;
  std::vector<std::string> files;                    ///< that they were read from
  std::map<std::string, std::string> file_of_input;  ///< by the input's name
};

/// "NAME=FILE.csv" and "FILE.csv", several: tables of one of these inputs, and of all that the table names
/// (mimbre/input_table.h). Throws InputError for what is no such table, UsageError for what is no such text.
InputTables input_tables(const std::vector<std::string>& given, const std::vector<spec::Input>& inputs);

/// Adds the option --input to a command.
void add_input_option(Parser& command, std::vector<std::string>& inputs);

}  // namespace mimbre::app
