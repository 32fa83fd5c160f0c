#include "app/input_tables.h"

#include <fmt/format.h>

#include <filesystem>

#include "app/common.h"
#include "mimbre/diagnostics.h"
#include "mimbre/input_table.h"

namespace mimbre::app {

InputTables input_tables(const std::vector<std::string>& given, const std::vector<spec::Input>& inputs) {
  InputTables result;
  for (const std::string& text : given) {
    const auto equals = text.find('=');
    const bool named = equals != std::string::npos && text.find('/') >= equals;  // which no name has
    const std::string name = named ? text.substr(0, equals) : "";
    const std::string path = named ? text.substr(equals + 1) : text;
    if (path.empty() || (named && name.empty()))
      throw UsageError(fmt::format("--input {}: NAME=FILE.csv or FILE.csv is needed", text));
    std::error_code failed;
    if (!std::filesystem::exists(path, failed))
      throw InputError({path, 0, 0}, fmt::format("there is no such file with {} values",
                                                 named ? "the input's" : "inputs'"));
    for (RecordedInput& input : read_input_table(path, inputs, name)) {
      const std::string& played = inputs[static_cast<std::size_t>(input.input)].name;
      if (result.tables.contains(played)) throw UsageError(fmt::format("--input {}: is given twice", played));
      result.file_of_input[played] = path;
      result.tables.add(played, std::move(input.times), std::move(input.values));
    }
    result.files.push_back(path);
  }
  return result;
}

void add_input_option(Parser& command, std::vector<std::string>& inputs) {
  command
      .add_option("--input", inputs,
                  "Plays an input, or a tunable parameter, from a table with the columns t and value,\n"
                  "or without NAME all inputs that the table's header names; may be repeated")
      .type_name("[NAME=]FILE.csv");
}

}  // namespace mimbre::app
